#include "daemon/command/plan_command.h"

#include <iostream>

#include "daemon/command/command.h"
#include "daemon/command/progress_line.h"

namespace tiltfeed::daemon {

int plan_command(const PlanFiles& files, const std::string& progress) {
  const Result<int> file = open_progress(progress, outputs_of(files));
  if (!file) return complain(file.error());
  Result<std::string> done;
  {
    ProgressLine line(*file);
    done = plan_program(files, {[&](const char* stage, double share) { return line.show(stage, share); },
                                [&](const std::string& text) { line.note(text); }});
  }
  if (!done) return complain(done.error());
  const bool taken = files.program == "-" || files.cl == "-" || files.report == "-" || files.map == "-";
  (taken ? std::cerr : std::cout) << *done;
  return kExitDone;
}

}  // namespace tiltfeed::daemon
