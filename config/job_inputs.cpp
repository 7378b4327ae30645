#include "config/job_inputs.h"

namespace tiltfeed::config {

std::vector<NamedFile> files_of(const Job& job) {
  std::vector<NamedFile> files{{"JOB", job.path},
                               {"part.stl", job.stl_path},
                               {"machine", job.machine.path},
                               {"cutter.library", job.tools_path}};
  if (job.blank) files.push_back({"blank.file", job.blank->path});
  for (const Fixture& fixture : job.fixtures) files.push_back({"fixture " + fixture.name, fixture.shape.stl});
  for (const MachineBody& body : job.machine.solid.bodies)
    files.push_back({"body " + body.name, body.shape.stl});
  return files;
}

}  // namespace tiltfeed::config
