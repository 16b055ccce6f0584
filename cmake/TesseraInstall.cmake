# What is installed beside the programs: documents in their folders, so that their links hold, a sample configuration, the
# examples; the daemon's configuration and unit; and the target `uninstall`.
include(GNUInstallDirs)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT tessera)
install(DIRECTORY docs examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT tessera)
install(FILES config/tessera.toml config/tesserad.toml DESTINATION ${CMAKE_INSTALL_DOCDIR}/config COMPONENT tessera)
install(FILES src/result/store/FORMAT.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/src/result/store COMPONENT tessera)
install(FILES data/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/data COMPONENT tessera)

# systemd reads units below /usr/local, too.
set(TESSERA_UNIT_FOLDER lib/systemd/system CACHE STRING "Where the unit of systemd is installed")
configure_file(deploy/tesserad.service.in deploy/tesserad.service @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/deploy/tesserad.service DESTINATION ${TESSERA_UNIT_FOLDER} COMPONENT tesserad)
# What a site has changed stays.
set(settings_folder ${CMAKE_INSTALL_SYSCONFDIR}/tessera)
install(CODE "set(folder \"${settings_folder}\")
cmake_path(ABSOLUTE_PATH folder BASE_DIRECTORY \"\${CMAKE_INSTALL_PREFIX}\")
if(NOT EXISTS \"\$ENV{DESTDIR}\${folder}/tesserad.toml\")
  file(INSTALL \"${PROJECT_SOURCE_DIR}/config/tesserad.toml\" DESTINATION \"\${folder}\")
endif()" COMPONENT tesserad)
install(FILES deploy/tesserad.bash-completion DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME tesserad
        COMPONENT tesserad)
install(FILES deploy/tesserad.8 DESTINATION ${CMAKE_INSTALL_MANDIR}/man8 COMPONENT tesserad)

add_custom_target(uninstall COMMAND ${CMAKE_COMMAND} -D MANIFEST=${PROJECT_BINARY_DIR}/install_manifest.txt
                                    -P ${CMAKE_CURRENT_LIST_DIR}/uninstall.cmake VERBATIM)
