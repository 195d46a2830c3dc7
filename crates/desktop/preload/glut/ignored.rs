//! Calls that change nothing of one picture, and calls that draw with OpenGL itself: the names of
//! OpenGL 1.3, GLU and GLUT that are not served elsewhere, and those that programs with shaders and
//! buffers call first.
//!
//! All of them are there, because a program that is linked with `-z now` does not start without
//! one. Each returns 0, which is also a null pointer, whatever its arguments are.

use crate::device::device;
use crate::elf::Unserved;
use core::sync::atomic::{AtomicUsize, Ordering};

/// Calls that were told, by the places of their names; later ones are not.
static TOLD: [AtomicUsize; 64] = [const { AtomicUsize::new(0) }; 64];

/// Tells the user that a call is not served, once.
pub fn tell(name: &'static [u8]) {
    let place = name.as_ptr() as usize;
    let is_new = |slot: &AtomicUsize| {
        slot.compare_exchange(0, place, Ordering::Relaxed, Ordering::Relaxed).map_or_else(Some, |_| None)
    };
    for slot in &TOLD {
        match is_new(slot) {
            Some(other) if other == place => return,
            Some(_) => {}
            None => {
                if let Some(device) = device() {
                    device.tell(Unserved::Geometry, name);
                }
                return;
            }
        }
    }
}

/// Defines functions that do nothing.
macro_rules! ignored {
    ($($name:ident)*) => {$(
        /// Changes nothing of a picture.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> usize {
            0
        }
    )*};
}

/// Defines functions that are told, each once.
macro_rules! told {
    ($($name:ident)*) => {$(
        /// Is not served.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> usize {
            tell(stringify!($name).as_bytes());
            0
        }
    )*};
}

ignored! {
    glActiveTexture glAlphaFunc glBlendFunc glClearAccum glClearDepth glClearIndex glClearStencil
    glColor3b glColor3bv glColor3d glColor3dv glColor3f glColor3fv glColor3i glColor3iv glColor3s
    glColor3sv glColor3ub glColor3ubv glColor3ui glColor3uiv glColor3us glColor3usv glColor4b glColor4bv
    glColor4d glColor4dv glColor4f glColor4fv glColor4i glColor4iv glColor4s glColor4sv glColor4ub
    glColor4ubv glColor4ui glColor4uiv glColor4us glColor4usv glColorMask glColorMaterial glCullFace
    glDepthFunc glDepthMask glDepthRange glDisableClientState glDrawBuffer glEdgeFlag glEdgeFlagPointer
    glEdgeFlagv glEnableClientState glFogf glFogfv glFogi glFogiv glFrontFace glGenerateMipmap
    glGetBooleanv glGetDoublev glGetError glGetFloatv glHint glIndexMask glIndexPointer glIndexd
    glIndexdv glIndexf glIndexfv glIndexi glIndexiv glIndexs glIndexsv glIndexub glIndexubv glIsTexture
    glLightModelf glLightModelfv glLightModeli glLightModeliv glLightf glLightfv glLighti glLightiv
    glLineStipple glLineWidth glLogicOp glMaterialf glMaterialfv glMateriali glMaterialiv
    glMultiTexCoord1d glMultiTexCoord1dv glMultiTexCoord1f glMultiTexCoord1fv glMultiTexCoord1i
    glMultiTexCoord1iv glMultiTexCoord1s glMultiTexCoord1sv glMultiTexCoord2d glMultiTexCoord2dv
    glMultiTexCoord2f glMultiTexCoord2fv glMultiTexCoord2i glMultiTexCoord2iv glMultiTexCoord2s
    glMultiTexCoord2sv glMultiTexCoord3d glMultiTexCoord3dv glMultiTexCoord3f glMultiTexCoord3fv
    glMultiTexCoord3i glMultiTexCoord3iv glMultiTexCoord3s glMultiTexCoord3sv glMultiTexCoord4d
    glMultiTexCoord4dv glMultiTexCoord4f glMultiTexCoord4fv glMultiTexCoord4i glMultiTexCoord4iv
    glMultiTexCoord4s glMultiTexCoord4sv glNormal3b glNormal3bv glNormal3d glNormal3dv glNormal3f
    glNormal3fv glNormal3i glNormal3iv glNormal3s glNormal3sv glPixelMapfv glPixelMapuiv glPixelMapusv
    glPixelStoref glPixelTransferf glPixelTransferi glPointSize glPolygonMode glPolygonOffset
    glPolygonStipple glPopAttrib glPopClientAttrib glPrioritizeTextures glPushAttrib glPushClientAttrib
    glReadBuffer glSampleCoverage glScissor glShadeModel glStencilFunc glStencilMask glStencilOp
    glTexEnvf glTexEnvfv glTexEnvi glTexEnviv glTexGend glTexGendv glTexGenf glTexGenfv glTexGeni
    glTexGeniv glTexParameterf glTexParameterfv glTexParameteri glTexParameteriv glViewport
    gluCheckExtension gluDeleteNurbsRenderer gluDeleteQuadric gluDeleteTess gluGetString gluNewQuadric
    gluQuadricCallback gluQuadricDrawStyle gluQuadricNormals gluQuadricOrientation gluQuadricTexture
    glutAddMenuEntry glutAddSubMenu glutAppStatusFunc glutAttachMenu glutButtonBoxFunc
    glutChangeToMenuEntry glutChangeToSubMenu glutCloseFunc glutCreateMenu glutDestroyMenu
    glutDetachMenu glutDeviceGet glutDialsFunc glutEntryFunc glutExtensionSupported
    glutForceJoystickFunc glutFullScreen glutFullScreenToggle glutGetColor glutGetMenu glutGetMenuData
    glutGetWindowData glutHideWindow glutIconifyWindow glutIgnoreKeyRepeat glutInitContextFlags
    glutInitContextProfile glutInitContextVersion glutInitDisplayMode glutInitDisplayString
    glutInitErrorFunc glutInitWarningFunc glutInitWindowPosition glutJoystickFunc glutLayerGet
    glutLeaveFullScreen glutMenuDestroyFunc glutMenuStateFunc glutMenuStatusFunc glutPopWindow
    glutPositionFunc glutPositionWindow glutPushWindow glutRemoveMenuItem glutReportErrors
    glutReshapeWindow glutSetColor glutSetCursor glutSetIconTitle glutSetKeyRepeat glutSetMenu
    glutSetMenuData glutSetMenuFont glutSetOption glutSetWindow glutSetWindowData glutSetWindowTitle
    glutShowWindow glutSpaceballButtonFunc glutSpaceballMotionFunc glutSpaceballRotateFunc
    glutTabletButtonFunc glutTabletMotionFunc glutUseLayer glutWMCloseFunc glutWarpPointer
    glutWindowStatusFunc
}

told! {
    glAccum glAreTexturesResident glArrayElement glAttachShader glBindBuffer glBindFramebuffer
    glBindVertexArray glBitmap glBlendColor glBlendEquation glBufferData glCallList glCallLists
    glClientActiveTexture glClipPlane glColorPointer glColorSubTable glColorTable
    glColorTableParameterfv glColorTableParameteriv glCompileShader glCompressedTexImage1D
    glCompressedTexImage2D glCompressedTexImage3D glCompressedTexSubImage1D glCompressedTexSubImage2D
    glCompressedTexSubImage3D glConvolutionFilter1D glConvolutionFilter2D glConvolutionParameterf
    glConvolutionParameterfv glConvolutionParameteri glConvolutionParameteriv glCopyColorSubTable
    glCopyColorTable glCopyConvolutionFilter1D glCopyConvolutionFilter2D glCopyPixels glCopyTexImage1D
    glCopyTexImage2D glCopyTexSubImage1D glCopyTexSubImage2D glCopyTexSubImage3D glCreateProgram
    glCreateShader glDeleteLists glDeleteShader glDrawArrays glDrawElements glDrawRangeElements
    glEGLImageTargetRenderbufferStorageOES glEGLImageTargetTexture2DOES glEnableVertexAttribArray
    glEndList glEvalCoord1d glEvalCoord1dv glEvalCoord1f glEvalCoord1fv glEvalCoord2d glEvalCoord2dv
    glEvalCoord2f glEvalCoord2fv glEvalMesh1 glEvalMesh2 glEvalPoint1 glEvalPoint2 glFeedbackBuffer
    glFrustum glGenBuffers glGenFramebuffers glGenLists glGenVertexArrays glGetClipPlane glGetColorTable
    glGetColorTableParameterfv glGetColorTableParameteriv glGetCompressedTexImage glGetConvolutionFilter
    glGetConvolutionParameterfv glGetConvolutionParameteriv glGetHistogram glGetHistogramParameterfv
    glGetHistogramParameteriv glGetLightfv glGetLightiv glGetMapdv glGetMapfv glGetMapiv glGetMaterialfv
    glGetMaterialiv glGetMinmax glGetMinmaxParameterfv glGetMinmaxParameteriv glGetPixelMapfv
    glGetPixelMapuiv glGetPixelMapusv glGetPointerv glGetPolygonStipple glGetProgramiv
    glGetSeparableFilter glGetShaderInfoLog glGetShaderiv glGetTexEnvfv glGetTexEnviv glGetTexGendv
    glGetTexGenfv glGetTexGeniv glGetTexImage glGetTexLevelParameterfv glGetTexLevelParameteriv
    glGetTexParameterfv glGetTexParameteriv glGetUniformLocation glHistogram glInitNames
    glInterleavedArrays glIsList glLinkProgram glListBase glLoadMatrixd glLoadName
    glLoadTransposeMatrixd glLoadTransposeMatrixf glMap1d glMap1f glMap2d glMap2f glMapGrid1d
    glMapGrid1f glMapGrid2d glMapGrid2f glMinmax glMultMatrixd glMultTransposeMatrixd
    glMultTransposeMatrixf glNewList glNormalPointer glPassThrough glPopName glPushName glRasterPos2dv
    glRasterPos2fv glRasterPos2iv glRasterPos2s glRasterPos2sv glRasterPos3d glRasterPos3dv
    glRasterPos3fv glRasterPos3i glRasterPos3iv glRasterPos3s glRasterPos3sv glRasterPos4d
    glRasterPos4dv glRasterPos4f glRasterPos4fv glRasterPos4i glRasterPos4iv glRasterPos4s
    glRasterPos4sv glRectd glRectdv glRectf glRectfv glRecti glRectiv glRects glRectsv glRenderMode
    glResetHistogram glResetMinmax glRotated glRotatef glSelectBuffer glSeparableFilter2D glShaderSource
    glTexCoord1d glTexCoord1dv glTexCoord1f glTexCoord1fv glTexCoord1i glTexCoord1iv glTexCoord1s
    glTexCoord1sv glTexCoord2iv glTexCoord2s glTexCoord2sv glTexCoord3d glTexCoord3dv glTexCoord3fv
    glTexCoord3i glTexCoord3iv glTexCoord3s glTexCoord3sv glTexCoord4d glTexCoord4dv glTexCoord4f
    glTexCoord4fv glTexCoord4i glTexCoord4iv glTexCoord4s glTexCoord4sv glTexCoordPointer glTexImage1D
    glTexImage3D glTexSubImage1D glTexSubImage3D glUniform1f glUniform1i glUniformMatrix4fv glUseProgram
    glVertex2sv glVertex3iv glVertex3s glVertex3sv glVertex4d glVertex4dv glVertex4f glVertex4fv
    glVertex4i glVertex4iv glVertex4s glVertex4sv glVertexAttribPointer glVertexPointer glWindowPos2f
    gluBeginCurve gluBeginPolygon gluBeginSurface gluBeginTrim gluBuild1DMipmapLevels gluBuild1DMipmaps
    gluBuild2DMipmapLevels gluBuild3DMipmapLevels gluBuild3DMipmaps gluCylinder gluDisk gluEndCurve
    gluEndPolygon gluEndSurface gluEndTrim gluGetNurbsProperty gluGetTessProperty
    gluLoadSamplingMatrices gluLookAt gluNewNurbsRenderer gluNewTess gluNextContour gluNurbsCallback
    gluNurbsCallbackData gluNurbsCurve gluNurbsProperty gluNurbsSurface gluPartialDisk gluPerspective
    gluPickMatrix gluProject gluPwlCurve gluScaleImage gluSphere gluTessBeginContour gluTessBeginPolygon
    gluTessCallback gluTessEndContour gluTessEndPolygon gluTessNormal gluTessProperty gluTessVertex
    gluUnProject gluUnProject4 glutBitmapCharacter glutBitmapHeight glutBitmapLength glutBitmapString
    glutBitmapWidth glutCopyColormap glutCreateSubWindow glutEnterGameMode glutEstablishOverlay
    glutGameModeGet glutGameModeString glutGetModeValues glutHideOverlay glutInitContextFunc
    glutJoystickGetCenter glutJoystickGetDeadBand glutJoystickGetMaxRange glutJoystickGetMinRange
    glutJoystickGetNumAxes glutJoystickGetNumButtons glutJoystickGetSaturation glutJoystickNotWorking
    glutJoystickSetCenter glutJoystickSetDeadBand glutJoystickSetMaxRange glutJoystickSetMinRange
    glutJoystickSetSaturation glutLeaveGameMode glutMultiButtonFunc glutMultiEntryFunc
    glutMultiMotionFunc glutMultiPassiveFunc glutOverlayDisplayFunc glutPostOverlayRedisplay
    glutPostWindowOverlayRedisplay glutRemoveOverlay glutSetVertexAttribCoord3 glutSetVertexAttribNormal
    glutSetVertexAttribTexCoord2 glutSetupVideoResizing glutShowOverlay glutSolidCone glutSolidCube
    glutSolidCylinder glutSolidDodecahedron glutSolidIcosahedron glutSolidOctahedron
    glutSolidRhombicDodecahedron glutSolidSierpinskiSponge glutSolidSphere glutSolidTeacup
    glutSolidTeapot glutSolidTeaspoon glutSolidTetrahedron glutSolidTorus glutStopVideoResizing
    glutStrokeCharacter glutStrokeHeight glutStrokeLength glutStrokeLengthf glutStrokeString
    glutStrokeWidth glutStrokeWidthf glutVideoPan glutVideoResize glutVideoResizeGet glutWireCone
    glutWireCube glutWireCylinder glutWireDodecahedron glutWireIcosahedron glutWireOctahedron
    glutWireRhombicDodecahedron glutWireSierpinskiSponge glutWireSphere glutWireTeacup glutWireTeapot
    glutWireTeaspoon glutWireTetrahedron glutWireTorus
}
