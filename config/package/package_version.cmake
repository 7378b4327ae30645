# tiltfeed_package_version(OUT SOURCE VERSION): the version that packages have. VERSION itself at the commit of its tag, vVERSION,
# and without git. After it: VERSION+TIME.COMMIT, by the commit's own time (UTC), so that a later commit is an upgrade.
function(tiltfeed_package_version out source version)
  set(${out} ${version} PARENT_SCOPE)
  if(NOT EXISTS ${source}/.git)
    return()
  endif()
  execute_process(COMMAND git -C ${source} describe --exact-match --tags --match v${version} --dirty OUTPUT_VARIABLE tag
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(tag STREQUAL "v${version}")
    return()
  endif()
  execute_process(COMMAND ${CMAKE_COMMAND} -E env TZ=UTC git -C ${source} log -1 --date=format-local:%Y%m%d%H%M%S --abbrev=12
                          --format=+%cd.%h OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND git -C ${source} describe --always --exclude=* --dirty OUTPUT_VARIABLE dirty ERROR_QUIET)
  if(dirty MATCHES "-dirty")
    string(APPEND commit ".changed")
  endif()
  set(${out} "${version}${commit}" PARENT_SCOPE)
endfunction()
