# What is installed beside the programs: documents in their folders, so that their links hold, a sample configuration, the
# examples; and the target `uninstall`.
include(GNUInstallDirs)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES config/tessera.toml DESTINATION ${CMAKE_INSTALL_DOCDIR}/config)
install(FILES src/store/FORMAT.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/src/store)
install(FILES data/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/data)
add_custom_target(uninstall COMMAND ${CMAKE_COMMAND} -D MANIFEST=${PROJECT_BINARY_DIR}/install_manifest.txt
                                    -P ${CMAKE_CURRENT_LIST_DIR}/uninstall.cmake VERBATIM)
