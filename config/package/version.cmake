# cmake -D VERSION=... -D SOURCE=... -D OUT=... -P version.cmake: writes OUT when what it says has changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --abbrev=12 --exclude=* --dirty=\ changed OUTPUT_VARIABLE commit
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE none)
set(text "${VERSION}")
if(none EQUAL 0 AND EXISTS ${SOURCE}/.git)
  string(APPEND text " (commit ${commit})")
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [=[// Made by config/package/version.cmake.
#include "config/version.h"

namespace tiltfeed::config {
std::string version() { return "@text@"; }
}  // namespace tiltfeed::config
]=])
