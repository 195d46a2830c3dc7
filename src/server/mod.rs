//! THE RENDER THREAD and everything around it: sessions, the in-process client, transports.
