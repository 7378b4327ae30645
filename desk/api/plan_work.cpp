#include "desk/api/plan_work.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "desk/work/progress_text.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

constexpr const char* kFiles[] = {"part.nc",  "part.map",  "path.f32", "report.json",
                                  "progress", "plan.yaml", "plan.stl"};

}  // namespace

Result<void> PlanWork::start(const PlanInput& input) {
  if (child_) return fail(Code::kUsage, "a plan is in work; cancel it first");
  const auto in_folder = [&](const char* name) { return folder_ + "/" + name; };
  std::error_code ignored;
  for (const char* name : kFiles) std::filesystem::remove(in_folder(name), ignored);
  // The planner reads both more than once, and what is on the desk may change while it works.
  std::error_code error;
  std::filesystem::copy_file(input.job, in_folder("plan.yaml"), error);
  if (!error) std::filesystem::create_hard_link(input.stl, in_folder("plan.stl"), error);
  if (error) return fail(Code::kIo, folder_ + ": " + error.message());
  std::vector<std::string> words({program_, "plan", in_folder("plan.yaml"), "--stl", in_folder("plan.stl"),
                                  "--machine", input.machine, "--out", in_folder("part.nc"), "--map",
                                  in_folder("part.map"), "--drawing", in_folder("path.f32"), "--report",
                                  in_folder("report.json"), "--progress", in_folder("progress")});
  if (!input.operation.empty()) words.insert(words.end(), {"--operation", input.operation});
  if (!input.optimise.empty()) words.insert(words.end(), {"--optimise", input.optimise});
  Result<ChildProcess> child = ChildProcess::start(words);
  if (!child) return tl::unexpected<Error>(child.error());
  child_.emplace(std::move(*child));
  ++id_;
  input_ = input;
  state_ = "planning";
  error_.clear();
  progress_.clear();
  cancelled_ = false;
  tell_("plan", describe());
  return {};
}

Result<void> PlanWork::cancel() {
  if (!child_) return fail(Code::kUsage, "no plan is in work");
  cancelled_ = true;
  child_->interrupt();
  return {};
}

void PlanWork::hear() {
  if (!child_ || !child_->listen()) return;
  const ChildEnd end = child_->end();
  child_.reset();
  state_ = end.status == 0 ? "planned" : cancelled_ ? "cancelled" : "refused";
  if (state_ == "refused") error_ = last_words(end.text, "tiltfeed: ", folder_ + "/");
  tell_("plan", describe());
}

void PlanWork::look() {
  if (!child_) return;
  std::ifstream in(folder_ + "/progress");
  std::string line;
  if (!std::getline(in, line) || line == progress_) return;
  progress_ = line;
  tell_("plan", describe());
}

std::string PlanWork::describe() const {
  if (id_ == 0) return "null";
  json about{{"id", id_}, {"job", input_.job_id}, {"part", input_.part_id}, {"state", state_}};
  if (!input_.operation.empty()) about["operation"] = input_.operation;
  if (!input_.optimise.empty()) about["optimise"] = input_.optimise;
  if (!error_.empty()) about["error"] = error_;
  if (const auto at = parse_progress(progress_); at && state_ == "planning")
    about["percent"] = at->percent, about["stage"] = at->stage;
  return about.dump(-1, ' ', true, json::error_handler_t::replace);
}

Reply PlanWork::file(const char* name, const char* type) const {
  if (state_ != "planned") return refusal(409, "there is no plan that is done");
  Reply reply;
  reply.type = type;
  reply.file = folder_ + "/" + name;
  return reply;
}

}  // namespace tiltfeed::desk
