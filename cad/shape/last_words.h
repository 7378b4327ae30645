#pragma once
// What this program was at when it had to end. OpenCASCADE 7.6 has faults in it that damaged files reach;
// whoever started the program is told where.

#include <string>

namespace tiltfeed::cad {

/// The stage, and the entity that it is at: "meshing #12 ADVANCED_FACE". Kept for hear_faults().
void now_at(const std::string& what);
/// What now_at() said last.
std::string at_now();

/// At SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT and SIGXCPU the program says on standard error what it was at,
/// and ends by that signal. `latest`: asked for the last entity that OpenCASCADE has finished; may be null.
void hear_faults();
/// Is asked in the handler for what is more exact than now_at(); null: nothing. It may fault itself.
void ask_in_fault(const char* (*latest)());

/// Memory in MB and processor time in seconds that this program may take; 0: no limit.
void limit_resources(int memory_mb, int seconds);

}  // namespace tiltfeed::cad
