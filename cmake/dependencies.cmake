# Every outside library of the core. What is missing is named with the Debian package that brings it.

function(surflux_missing library package)
  message(FATAL_ERROR "surflux needs ${library}, which was not found. "
    "On Debian or Ubuntu: sudo apt-get install ${package}")
endfunction()

find_package(TBB QUIET CONFIG)
if(NOT TBB_FOUND)
  surflux_missing("oneTBB" "libtbb-dev")
endif()

find_package(Eigen3 3.3 QUIET CONFIG)
if(NOT Eigen3_FOUND)
  surflux_missing("Eigen 3" "libeigen3-dev")
endif()

find_package(embree 4 QUIET CONFIG)
if(NOT embree_FOUND)
  find_package(embree 3 QUIET CONFIG)
endif()
if(NOT embree_FOUND)
  surflux_missing("Embree 4 or 3" "libembree-dev")
endif()

find_package(flann QUIET CONFIG)
if(NOT flann_FOUND)
  surflux_missing("FLANN" "libflann-dev")
endif()

# OpenImageIO's own config aborts without its tools; look for them first, so that the message stays ours.
find_program(SURFLUX_OIIOTOOL oiiotool)
find_path(SURFLUX_OIIO_HEADERS OpenImageIO/imageio.h)
if(NOT SURFLUX_OIIOTOOL OR NOT SURFLUX_OIIO_HEADERS)
  surflux_missing("OpenImageIO" "libopenimageio-dev openimageio-tools")
endif()
find_package(OpenImageIO QUIET CONFIG)
if(NOT OpenImageIO_FOUND)
  surflux_missing("OpenImageIO" "libopenimageio-dev openimageio-tools")
endif()
# Debian's target names include folders of OpenCV, which nothing here needs.
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${OpenImageIO_INCLUDE_DIR}")

# EGL and OSMesa give headers only: both libraries are opened at run time, when a GL pass is asked for.
find_path(SURFLUX_EGL_HEADERS EGL/egl.h)
find_path(SURFLUX_GL_HEADERS GL/glcorearb.h)
if(NOT SURFLUX_EGL_HEADERS)
  surflux_missing("the EGL headers" "libegl-dev")
endif()
if(NOT SURFLUX_GL_HEADERS)
  surflux_missing("the OpenGL headers" "libopengl-dev")
endif()

find_package(GTest QUIET)
if(SURFLUX_BUILD_TESTS AND NOT GTest_FOUND)
  surflux_missing("GoogleTest" "libgtest-dev")
endif()
