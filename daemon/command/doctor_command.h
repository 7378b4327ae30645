#pragma once
// `tiltfeed doctor`, and `tiltfeed serve --check`: whether a service can do its work.

#include <memory>
#include <string>

#include "daemon/doctor/doctor.h"

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// The configuration of `tiltfeed serve`, read and judged; nothing is started or changed. The exit status.
int check_service(const std::string& config, bool as_json);

/// All that the doctor has to say of this computer and, where `config` is not empty, of that service. `open`:
/// the controller is asked, too. `version`: of this program; those beside it must be of the same.
Findings examine(const std::string& config, const std::string& version, bool open);
/// A line each.
std::string findings_text(const Findings& findings);

/// Adds the command to the command line; after it is parsed, runs it.
class DoctorCommand {
 public:
  /// `version`: of this program; those beside it must be of the same.
  DoctorCommand(CLI::App& app, const std::string& version);
  ~DoctorCommand();
  DoctorCommand(const DoctorCommand&) = delete;
  DoctorCommand& operator=(const DoctorCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 all is good, 1 there is something to do.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
