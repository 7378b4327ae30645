# What is installed, and where: cmake --install, and the Debian package that ./run package makes of the same tree.
include(GNUInstallDirs)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # no tests
set(CPACK_PACKAGE_CONTACT "Tiltfeed maintainers <maintainers@tiltfeed.example>")
set(share ${CMAKE_INSTALL_DATAROOTDIR}/tiltfeed)

# They look for each other beside themselves.
install(TARGETS tiltfeed tiltfeed-sim RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TILTFEED_DESK)
  install(TARGETS tiltfeed-desk RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT desk)
endif()
if(TILTFEED_CAD)
  install(TARGETS tiltfeed-cad RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT cad)
endif()

# systemd, udev and sysusers look in lib, never in lib/ARCHITECTURE.
install(FILES config/systemd/tiltfeed@.service config/systemd/tiltfeed-mtconnect@.service DESTINATION lib/systemd/system)
if(TILTFEED_DESK)
  install(FILES config/systemd/tiltfeed-desk@.service DESTINATION lib/systemd/system COMPONENT desk)
  install(FILES config/package/desk/sysusers.conf DESTINATION lib/sysusers.d RENAME tiltfeed-desk.conf COMPONENT desk)
endif()
install(FILES config/udev/60-tiltfeed.rules DESTINATION lib/udev/rules.d)
install(FILES config/package/sysusers.conf DESTINATION lib/sysusers.d RENAME tiltfeed.conf)

install(FILES config/prometheus/tiltfeed.rules.yaml config/prometheus/dashboard.json DESTINATION ${share}/prometheus)

# Example jobs: copied to a folder of one's own, they find their part beside themselves.
install(DIRECTORY config/machines config/tools DESTINATION ${share} FILES_MATCHING PATTERN "*.yaml")
file(GLOB jobs CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/config/jobs/*.yaml)
foreach(job IN LISTS jobs)
  get_filename_component(name ${job} NAME)
  file(READ ${job} text)
  string(REPLACE "../../build/demo/" "" text "${text}")
  string(REPLACE "build/demo/" "" text "${text}")
  string(REPLACE "machine: ../machines/" "machine: ${CMAKE_INSTALL_FULL_DATAROOTDIR}/tiltfeed/machines/" text "${text}")
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/install/jobs/${name} CONTENT "${text}" @ONLY)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${job})
  install(FILES ${CMAKE_BINARY_DIR}/install/jobs/${name} DESTINATION ${share}/jobs)
endforeach()
file(READ config/service.yaml text)
string(REPLACE "machine: machines/" "machine: ${CMAKE_INSTALL_FULL_DATAROOTDIR}/tiltfeed/machines/" text "${text}")
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/install/service.yaml CONTENT "${text}" @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/install/service.yaml DESTINATION ${share})
if(TILTFEED_DESK)
  install(FILES config/desk.yaml DESTINATION ${share} COMPONENT desk)
endif()

install(FILES README.md GLOSSARY.md config/package/copyright DESTINATION ${CMAKE_INSTALL_DOCDIR})
# What who sets a machine up needs, under the names that README.md links to.
function(tiltfeed_pages component)
  foreach(page ${ARGN})
    get_filename_component(folder ${page} DIRECTORY)
    install(FILES ${page} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder} COMPONENT ${component})
  endforeach()
endfunction()
tiltfeed_pages(Unspecified config/README.md daemon/doctor/README.md daemon/metrics/README.md daemon/mtconnect/README.md
               daemon/service/README.md daemon/service/API.md daemon/shop/README.md daemon/wire/MODBUS.md)
if(TILTFEED_DESK)
  tiltfeed_pages(desk desk/README.md desk/API.md desk/webhooks/README.md)
endif()
# Manual pages and completion, by the programs themselves; changelogs.
set(made_by tiltfeed tiltfeed-sim)
if(TILTFEED_DESK)
  list(APPEND made_by tiltfeed-desk)
endif()
if(TILTFEED_CAD)
  list(APPEND made_by tiltfeed-cad)
endif()
set(manual ${CMAKE_BINARY_DIR}/install/manual)
add_custom_command(OUTPUT install/manual.stamp
                   COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual}
                   COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:tiltfeed> -D OUT=${manual} -D SOURCE=${CMAKE_SOURCE_DIR}
                           -D CONTACT=${CPACK_PACKAGE_CONTACT} -D VERSION=${PROJECT_VERSION}
                           -P ${CMAKE_SOURCE_DIR}/config/package/documents.cmake
                   COMMAND ${CMAKE_COMMAND} -E touch install/manual.stamp
                   DEPENDS ${made_by} config/package/documents.cmake config/package/package_version.cmake CHANGELOG.md VERBATIM)
add_custom_target(tiltfeed_documents ALL DEPENDS install/manual.stamp)
install(DIRECTORY ${manual}/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR} REGEX "/_?tiltfeed-(cad|desk)[^/]*$" EXCLUDE)
# What it is made of, from what was compiled and linked: needs ninja's own record of the headers, and dpkg.
function(tiltfeed_parts component package)
  if(CMAKE_GENERATOR STREQUAL Ninja AND EXISTS /usr/bin/dpkg)
    list(TRANSFORM ARGN REPLACE "(.+)" "\"$<TARGET_FILE:\\1>\"" OUTPUT_VARIABLE programs)
    string(JOIN " " programs ${programs})
    install(CODE "include(\"${CMAKE_SOURCE_DIR}/config/package/package_version.cmake\")
    tiltfeed_package_version(version \"${CMAKE_SOURCE_DIR}\" ${PROJECT_VERSION})
    execute_process(
      COMMAND \"${CMAKE_SOURCE_DIR}/config/package/sbom.sh\" \"${CMAKE_BINARY_DIR}\" \"${CMAKE_SOURCE_DIR}\" \${version} ${package} ${programs}
      OUTPUT_FILE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATAROOTDIR}/doc/${package}/sbom.spdx.json\" COMMAND_ERROR_IS_FATAL ANY)"
            COMPONENT ${component})
  endif()
endfunction()
tiltfeed_parts(Unspecified tiltfeed tiltfeed tiltfeed-sim)
install(FILES config/package/lintian-overrides DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/lintian/overrides RENAME tiltfeed)

# A program with a package of its own: its pages, completion, licence, changelog and parts.
function(tiltfeed_package_beside component)
  set(package tiltfeed-${component})
  foreach(folder ${ARGN} man/man1 bash-completion/completions zsh/vendor-completions fish/vendor_completions.d)
    install(DIRECTORY ${manual}/${folder}/ DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/${folder} COMPONENT ${component}
            FILES_MATCHING REGEX "/_?${package}[^/]*$")
  endforeach()
  install(FILES config/package/copyright ${manual}/doc/tiltfeed/changelog.gz DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package}
          COMPONENT ${component})
  tiltfeed_parts(${component} ${package} ${package})
endfunction()
if(TILTFEED_DESK)
  tiltfeed_package_beside(desk man/man5)
  install(FILES config/package/desk/lintian-overrides DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/lintian/overrides RENAME tiltfeed-desk
          COMPONENT desk)
endif()
if(TILTFEED_CAD)
  tiltfeed_package_beside(cad)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tiltfeed)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "5-axis milling from an STL part to the machine")
set(CPACK_PACKAGE_DESCRIPTION
    "Plans tool paths for a 5-axis mill with a rotary table and a tilting head,
proves them against the part, posts them for the control, and streams them
over a serial line or Modbus. A simulated machine and material removal judge
every program. Not a safety device.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_SOURCE_DIR}/config/package/permissions.cmake)
set(CPACK_SOURCE ${CMAKE_SOURCE_DIR})
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_SOURCE_DIR}/config/package/pack.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# Packages of their own: the page and its server, which has a user and a unit; the reader of STEP and IGES files, since
# OpenCASCADE brings 66 libraries. No machine needs either.
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL Unspecified)
set(scripts postinst prerm postrm)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME tiltfeed)
set(CPACK_DEBIAN_UNSPECIFIED_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION_SUMMARY}\n${CPACK_PACKAGE_DESCRIPTION}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY)
list(TRANSFORM scripts PREPEND ${CMAKE_SOURCE_DIR}/config/package/ OUTPUT_VARIABLE CPACK_DEBIAN_UNSPECIFIED_PACKAGE_CONTROL_EXTRA)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS systemd)
if(TILTFEED_DESK)
  list(APPEND CPACK_COMPONENTS_ALL desk)
  string(APPEND CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS ", tiltfeed-desk")
  set(CPACK_DEBIAN_DESK_PACKAGE_NAME tiltfeed-desk)
  set(CPACK_DEBIAN_DESK_DESCRIPTION "page in the browser for tiltfeed
Serves a page that shows a part, its job, its tool path and the run on the
machine, and one of all machines of a shop. Also metrics for Prometheus and
webhooks for the shop's own programs.")
  list(TRANSFORM scripts PREPEND ${CMAKE_SOURCE_DIR}/config/package/desk/ OUTPUT_VARIABLE CPACK_DEBIAN_DESK_PACKAGE_CONTROL_EXTRA)
endif()
if(TILTFEED_CAD)
  list(APPEND CPACK_COMPONENTS_ALL cad)
  string(APPEND CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS ", tiltfeed-cad")
  set(CPACK_DEBIAN_CAD_PACKAGE_NAME tiltfeed-cad)
  set(CPACK_DEBIAN_CAD_DESCRIPTION "STEP and IGES files for tiltfeed
Makes facets of the surfaces of a CAD file, within a distance that is
measured, for the planner of tool paths.")
endif()
include(CPack)
