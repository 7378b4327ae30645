#pragma once
// The table of a spool: its version, and the way from every earlier one.

#include <string>

#include "kinematics/basics/result.h"

struct sqlite3;

namespace tiltfeed::daemon {

/// Kept in the database (PRAGMA user_version); 0: of before versions were kept, with a table or without.
inline constexpr int kSpoolVersion = 7;

/// Makes the table, or brings it up to date, in one transaction: afterwards it is of this version or as it
/// was. Errors: kIo; kUsage for a table of a later version, which stays as it is.
Result<void> bring_up_to_date(sqlite3* db, const std::string& path);

}  // namespace tiltfeed::daemon
