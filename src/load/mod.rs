//! Files in: OBJ, MTL, X3D and pictures become scene data. Bad files are refused with file, line and reason.
