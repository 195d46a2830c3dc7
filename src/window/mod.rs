//! PIXELS OUT to the screen: the minifb window and its keys. The only room that knows minifb and its 0RGB words.
