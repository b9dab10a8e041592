# Embree as script/wheel lays it out: headers of a Debian package, the library of a package of the Python index.
get_filename_component(embree_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET embree)
  add_library(embree SHARED IMPORTED)
  set_target_properties(embree PROPERTIES
    IMPORTED_LOCATION "${embree_prefix}/lib/libembree4.so.4"
    IMPORTED_SONAME libembree4.so.4
    INTERFACE_INCLUDE_DIRECTORIES "${embree_prefix}/include")
endif()
