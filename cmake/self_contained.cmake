# hnav_self_contained(TARGET MAP [OPTIONS...]): a shared library that holds no code that nobody calls, needs nothing beside the system's
# libraries and shows the names in MAP alone. OPTIONS: more for linkers of ELF files.
function(hnav_self_contained target map)
  if(APPLE)
    # Apple's linkers know no version scripts: what is not marked as exported is hidden when it is compiled.
    target_link_options(${target} PRIVATE -Wl,-dead_strip)
    # Otherwise the name by which others ask for it is its place in the build.
    set_target_properties(${target} PROPERTIES INSTALL_NAME_DIR "@rpath" BUILD_WITH_INSTALL_NAME_DIR ON)
    return()
  endif()
  target_link_options(${target} PRIVATE -Wl,--gc-sections)
  # Of a DLL the marked names are what it shows.
  if(NOT WIN32)
    # A version script, which every linker knows: the C++ library inside a binary by zig stays inside.
    target_link_options(${target} PRIVATE -Wl,-z,defs ${ARGN} -Wl,--version-script=${map})
    set_property(TARGET ${target} PROPERTY LINK_DEPENDS ${map})
  endif()
endfunction()
