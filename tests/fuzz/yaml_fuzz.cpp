// Settings: a job, a service's file and a machine profile from any text; what is refused has its place.

#include "config/job.h"
#include "config/machine_profile.h"
#include "config/service_config.h"
#include "tests/fuzz/fuzz.h"

namespace {

/// A place in the file itself, or in the profile that it names by a whole path.
bool names_a_file(const std::string& message) {
  return message.find("/nowhere/fuzz.yaml") != std::string::npos ||
         (message.starts_with('/') && message.find(':') != std::string::npos);
}

}  // namespace

FUZZ_TARGET(yaml) {
  const std::string text(bytes);
  if (const auto machine = tiltfeed::config::parse_machine(text, "fuzz.yaml"))
    HOLDS(!tiltfeed::config::describe(*machine).empty() && machine->model.x.min < machine->model.x.max);
  else
    HOLDS(machine.error().message.find("fuzz.yaml") != std::string::npos);
  if (const auto job = tiltfeed::config::parse_job(text, "/nowhere/fuzz.yaml"))
    HOLDS(job->plan.tolerance > 0.0);
  else
    HOLDS(names_a_file(job.error().message));
  if (const auto service = tiltfeed::config::parse_service_config(text, "/nowhere/fuzz.yaml"); !service)
    HOLDS(names_a_file(service.error().message));
}
