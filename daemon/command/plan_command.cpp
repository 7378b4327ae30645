#include "daemon/command/plan_command.h"

#include <algorithm>
#include <iostream>

#include "daemon/command/command.h"
#include "daemon/command/progress_line.h"

namespace tiltfeed::daemon {

namespace {

/// The file of one operation; empty: none.
std::string file_of(const std::string& file, const std::string& operation) {
  if (file.empty()) return file;
  std::string name = "-" + operation;
  std::replace(name.begin(), name.end(), ' ', '-');
  const std::size_t slash = file.rfind('/'), dot = file.rfind('.');
  const bool ends = dot != file.npos && dot > 0 && (slash == file.npos || dot > slash + 1);
  return ends ? file.substr(0, dot) + name + file.substr(dot) : file + name;
}

/// A planning for each operation of the job.
Result<std::vector<PlanFiles>> plannings(const PlanFiles& files) {
  const auto jobs = config::load_operations(
      files.job, {.stl = files.stl, .machine = files.machine, .closed = files.alone || files.closed});
  if (!jobs) return tl::unexpected(jobs.error());
  if (jobs->front().operation.name.empty())
    return fail(Code::kUsage, files.job + ": has no list of operations; leave out --each");
  for (const std::string& file : {files.program, files.cl, files.report, files.map, files.drawing})
    if (file == "-") return fail(Code::kUsage, "--each writes several files; standard output takes one");
  std::vector<PlanFiles> all;
  for (const config::Job& job : *jobs) {
    PlanFiles one = files;
    one.operation = job.operation.name;
    for (std::string* file : {&one.program, &one.cl, &one.report, &one.map, &one.drawing, &one.gouge_picture})
      *file = file_of(*file, one.operation);
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

int plan_command(const PlanFiles& files, bool each, const std::string& progress) {
  const auto all = each ? plannings(files) : Result<std::vector<PlanFiles>>(std::vector<PlanFiles>{files});
  if (!all) return complain(all.error());
  std::vector<config::NamedFile> outputs;
  for (const PlanFiles& one : *all)
    for (const config::NamedFile& file : outputs_of(one)) outputs.push_back(file);
  const Result<int> file = open_progress(progress, outputs);
  if (!file) return complain(file.error());
  std::string told;
  for (const PlanFiles& one : *all) {
    Result<std::string> done;
    {
      ProgressLine line(*file);
      done = plan_program(one, {[&](const char* stage, double share) { return line.show(stage, share); },
                                [&](const std::string& text) { line.note(text); }});
    }
    if (!done) return complain(done.error());
    told += (told.empty() || !files.as_json ? "" : ",\n") + *done;
  }
  if (each && files.as_json) told = "[\n" + told + "]\n";
  const bool taken = files.program == "-" || files.cl == "-" || files.report == "-" || files.map == "-";
  (taken ? std::cerr : std::cout) << told;
  return kExitDone;
}

}  // namespace tiltfeed::daemon
