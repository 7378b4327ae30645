// Settings: a job, a service's file and a machine profile from any text; what is refused has its place.

#include "config/job.h"
#include "config/machine_profile.h"
#include "config/service_config.h"
#include "tests/fuzz/fuzz.h"

FUZZ_TARGET(yaml) {
  const std::string text(bytes);
  if (const auto machine = tiltfeed::parse_machine(text, "fuzz.yaml"))
    HOLDS(!tiltfeed::describe(*machine).empty() && machine->model.x.min < machine->model.x.max);
  else
    HOLDS(machine.error().message.find("fuzz.yaml") != std::string::npos);
  if (const auto job = tiltfeed::parse_job(text, "/nowhere/fuzz.yaml"))
    HOLDS(job->plan.tolerance > 0.0);
  else
    HOLDS(job.error().message.find("nowhere") != std::string::npos);
  if (const auto service = tiltfeed::parse_service_config(text, "/nowhere/fuzz.yaml"); !service)
    HOLDS(service.error().message.find("nowhere") != std::string::npos);
}
