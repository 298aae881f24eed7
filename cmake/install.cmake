# SPDX-License-Identifier: GPL-3.0-or-later
# Where thermotwin is installed. Components: program (what a user runs) and development (what a C++ program links).
set(thermotwin_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/thermotwin)
set(thermotwin_module_dir ${CMAKE_INSTALL_LIBDIR}/thermotwin)  # what the program loads while it runs
set(thermotwin_data_dir ${CMAKE_INSTALL_DATADIR}/thermotwin)
file(RELATIVE_PATH thermotwin_modules_from_program ${CMAKE_INSTALL_FULL_BINDIR}
  ${CMAKE_INSTALL_FULL_LIBDIR}/thermotwin)

# The target thermotwin_<name> as thermotwin::<name> of find_package(thermotwin).
function(thermotwin_install_library name)
  set_target_properties(thermotwin_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS thermotwin_${name} EXPORT thermotwin-targets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
endfunction()

# All that is no target of its own: package files, cases, documents, examples.
function(thermotwin_install_files)
  include(CMakePackageConfigHelpers)
  configure_package_config_file(cmake/thermotwin-config.cmake.in thermotwin-config.cmake
    INSTALL_DESTINATION ${thermotwin_config_dir} PATH_VARS thermotwin_data_dir)
  write_basic_package_version_file(${CMAKE_BINARY_DIR}/thermotwin-config-version.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${CMAKE_BINARY_DIR}/thermotwin-config.cmake ${CMAKE_BINARY_DIR}/thermotwin-config-version.cmake
    cmake/libraries.cmake cmake/eigen_stays_inside.map DESTINATION ${thermotwin_config_dir} COMPONENT development)
  install(EXPORT thermotwin-targets NAMESPACE thermotwin:: DESTINATION ${thermotwin_config_dir} COMPONENT development)

  # As in the repository's root: the commands of the documents run in a copy of this folder.
  install(DIRECTORY cases DESTINATION ${thermotwin_data_dir} COMPONENT program)
  install(DIRECTORY tests/cases/toy DESTINATION ${thermotwin_data_dir}/tests/cases COMPONENT program)
  install(FILES README.md LICENSE cmake/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
  install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
  # Pages that the documents link to.
  foreach(folder core mesh solver reduction compensation diagnosis metrology nc study tools tests tests/cases
      tests/hidden_effects tests/verification cases cases/ac5 cases/budgets cases/finishing cases/mill cases/turnmill
      cases/vmc5)
    install(FILES ${folder}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder} COMPONENT program)
  endforeach()
  install(CODE "set(thermotwin_documents \"${CMAKE_INSTALL_DOCDIR}\")" COMPONENT program)
  install(SCRIPT cmake/plain_links.cmake COMPONENT program)
  install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
endfunction()
