# cmake -D PROGRAM=tiltfeed -D SOURCE=... -D OUT=... -D CONTACT=... -D VERSION=... -P documents.cmake: the tree that goes
# to /usr/share, packed without times of this moment: those of the commit, where there is one.
include(${SOURCE}/config/package/package_version.cmake)
tiltfeed_package_version(VERSION ${SOURCE} ${VERSION})
execute_process(COMMAND git -C ${SOURCE} log -1 --format=%cs%n%cD OUTPUT_VARIABLE dates OUTPUT_STRIP_TRAILING_WHITESPACE
                ERROR_QUIET)
if(dates MATCHES "^(.*)\n(.*)$")
  set(date ${CMAKE_MATCH_1})
  set(mail_date ${CMAKE_MATCH_2})
else()
  file(TIMESTAMP ${SOURCE}/CHANGELOG.md date %Y-%m-%d UTC)
  file(TIMESTAMP ${SOURCE}/CHANGELOG.md mail_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()
execute_process(COMMAND ${PROGRAM} write-manual ${OUT} --date ${date} COMMAND_ERROR_IS_FATAL ANY)
# Debian's own form beside ours.
file(WRITE ${OUT}/doc/tiltfeed/changelog "tiltfeed (${VERSION}) unstable; urgency=medium

  * What has changed: CHANGELOG.md.gz, beside this file.

 -- ${CONTACT}  ${mail_date}
")
file(COPY ${SOURCE}/CHANGELOG.md DESTINATION ${OUT}/doc/tiltfeed)
file(GLOB pages ${OUT}/man/man*/* ${OUT}/doc/tiltfeed/*)
execute_process(COMMAND gzip -9n ${pages} COMMAND_ERROR_IS_FATAL ANY)
