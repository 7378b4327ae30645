#include "desk/api/machine_work.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "desk/http/access_check.h"
#include "desk/work/progress_text.h"

namespace tiltfeed::desk {

using nlohmann::json;

void MachineWork::start(const std::string& job, const std::string& machine, std::uint64_t job_id) {
  child_.reset();
  ++id_;
  job_ = job_id;
  state_ = "working";
  error_.clear();
  // The job's text may change while it is read.
  const std::string copy = folder_ + "/machine.yaml";
  std::error_code error;
  std::filesystem::copy_file(job, copy, std::filesystem::copy_options::overwrite_existing, error);
  if (error) return refuse(folder_ + ": " + error.message());
  Result<ChildProcess> child = ChildProcess::start(
      {program_, "machine", copy, "--machine", machine, "--out", folder_ + "/machine.view"});
  if (!child) return refuse(child.error().message);
  child_.emplace(std::move(*child));
}

void MachineWork::refuse(const std::string& why) {
  state_ = "refused";
  error_ = why;
  tell_("machine", describe());
}

void MachineWork::hear() {
  if (!child_ || !child_->listen()) return;
  const ChildEnd end = child_->end();
  child_.reset();
  if (end.status != 0) return refuse(last_words(end.text, "tiltfeed-sim: ", folder_ + "/"));
  state_ = "ready";
  has_view_ = true;
  tell_("machine", describe());
}

std::string MachineWork::describe() const {
  if (id_ == 0) return "null";
  json about{{"id", id_}, {"job", job_}, {"state", state_}};
  if (!error_.empty()) about["error"] = error_;
  return about.dump(-1, ' ', true, json::error_handler_t::replace);
}

Reply MachineWork::view() const {
  if (!has_view_) return refusal(409, "the machine has not been read; a job without errors is needed");
  Reply reply;
  reply.type = kOctets;
  reply.file = folder_ + "/machine.view";
  return reply;
}

}  // namespace tiltfeed::desk
