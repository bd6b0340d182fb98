# find_package(actuator_c): the targets actuator_c::shared and actuator_c::static.
get_filename_component(_actuator_c_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET actuator_c::shared)
  add_library(actuator_c::shared SHARED IMPORTED)
  set_target_properties(actuator_c::shared PROPERTIES
    IMPORTED_LOCATION "${_actuator_c_prefix}/lib/libactuator_c.so.@VERSION@"
    IMPORTED_SONAME "libactuator_c.so.@ABI_VERSION@"
    INTERFACE_INCLUDE_DIRECTORIES "${_actuator_c_prefix}/include")
endif()

if(NOT TARGET actuator_c::static)
  add_library(actuator_c::static STATIC IMPORTED)
  set_target_properties(actuator_c::static PROPERTIES
    IMPORTED_LOCATION "${_actuator_c_prefix}/lib/libactuator_c.a"
    INTERFACE_INCLUDE_DIRECTORIES "${_actuator_c_prefix}/include"
    INTERFACE_LINK_LIBRARIES "m;pthread;dl")
endif()

unset(_actuator_c_prefix)
