# Every outside library of the core. Whatever is missing is named, all at once, with the Debian packages that bring it.

set(surflux_missing_libraries "")
set(surflux_missing_packages "")

macro(surflux_missing library)
  list(APPEND surflux_missing_libraries "${library}")
  list(APPEND surflux_missing_packages ${ARGN})
endmacro()

find_package(TBB QUIET CONFIG)
if(NOT TBB_FOUND)
  surflux_missing("oneTBB" libtbb-dev)
endif()

find_package(Eigen3 3.3 QUIET CONFIG)
if(NOT Eigen3_FOUND)
  surflux_missing("Eigen 3" libeigen3-dev)
endif()

# Embree's config aborts where TBB is missing: do not load it then, and ask for both.
if(TBB_FOUND)
  find_package(embree 4 QUIET CONFIG)
  if(NOT embree_FOUND)
    find_package(embree 3 QUIET CONFIG)
  endif()
endif()
if(NOT embree_FOUND)
  surflux_missing("Embree 4 or 3" libembree-dev)
endif()

find_package(flann QUIET CONFIG)
if(NOT flann_FOUND)
  surflux_missing("FLANN" libflann-dev)
endif()

# OpenImageIO's own config aborts where its tools are missing, and reports at length a Python library of Imath that
# Debian packs elsewhere: look for the tools first, and let status messages be quiet inside this function. Who names
# another OpenImageIO by OpenImageIO_DIR needs no tools.
function(surflux_find_openimageio)
  find_program(SURFLUX_OIIOTOOL oiiotool)
  find_path(SURFLUX_OIIO_HEADERS OpenImageIO/imageio.h)
  if(OpenImageIO_DIR OR (SURFLUX_OIIOTOOL AND SURFLUX_OIIO_HEADERS))
    set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
    find_package(OpenImageIO QUIET CONFIG)
  endif()
  set(OpenImageIO_FOUND "${OpenImageIO_FOUND}" PARENT_SCOPE)
  if(OpenImageIO_FOUND)
    # Debian's target names include folders of OpenCV, which nothing here needs.
    set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
      INTERFACE_INCLUDE_DIRECTORIES "${OpenImageIO_INCLUDE_DIR}")
  endif()
endfunction()
surflux_find_openimageio()
if(NOT OpenImageIO_FOUND)
  surflux_missing("OpenImageIO and its tools" libopenimageio-dev openimageio-tools)
endif()

# EGL and OSMesa give headers only: both libraries are opened at run time, when a GL pass is asked for.
find_path(SURFLUX_EGL_HEADERS EGL/egl.h)
if(NOT SURFLUX_EGL_HEADERS)
  surflux_missing("the EGL headers" libegl-dev)
endif()
find_path(SURFLUX_GL_HEADERS GL/glcorearb.h)
if(NOT SURFLUX_GL_HEADERS)
  surflux_missing("the OpenGL headers" libgl-dev)
endif()

if(SURFLUX_BUILD_TESTS)
  find_package(GTest QUIET)
  if(NOT GTest_FOUND)
    surflux_missing("GoogleTest" libgtest-dev)
  endif()
endif()

if(SURFLUX_BUILD_PYTHON)
  find_package(Python 3.11 QUIET COMPONENTS Interpreter Development.Module)
  if(NOT Python_FOUND)
    surflux_missing("Python 3.11 or newer with its headers" python3-dev)
  endif()
endif()

if(surflux_missing_libraries)
  list(JOIN surflux_missing_libraries ", " surflux_missing_libraries)
  list(JOIN surflux_missing_packages " " surflux_missing_packages)
  # CMake leaves indented lines as they are, so that the command can be copied whole.
  message(FATAL_ERROR "surflux needs what was not found here: ${surflux_missing_libraries}.\n"
    "On Debian or Ubuntu:\n  sudo apt-get install ${surflux_missing_packages}\n")
endif()
