# When packages are packed: their version, which is of the commit and not of when the build folder was configured.
include(${CPACK_SOURCE}/config/package/package_version.cmake)
tiltfeed_package_version(CPACK_PACKAGE_VERSION ${CPACK_SOURCE} ${CPACK_PACKAGE_VERSION})
set(CPACK_DEBIAN_DESK_PACKAGE_DEPENDS "tiltfeed (= ${CPACK_PACKAGE_VERSION})")
set(CPACK_DEBIAN_CAD_PACKAGE_DEPENDS "tiltfeed (= ${CPACK_PACKAGE_VERSION})")
# Its files were tiltfeed's before.
set(CPACK_DEBIAN_DESK_PACKAGE_REPLACES "tiltfeed (<< ${CPACK_PACKAGE_VERSION})")
set(CPACK_DEBIAN_DESK_PACKAGE_BREAKS "tiltfeed (<< ${CPACK_PACKAGE_VERSION})")
