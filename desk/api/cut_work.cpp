#include "desk/api/cut_work.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "desk/work/progress_text.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

constexpr int kIncomplete = 3;  // exit status of `tiltfeed verify`

}  // namespace

Result<void> CutWork::start(const CutInput& input) {
  if (child_) return fail(Code::kUsage, "a cut is in work; cancel it first");
  std::error_code ignored, error;
  if (state_ == "done") {
    std::filesystem::remove_all(at("before"), ignored);
    std::filesystem::rename(at("cut"), at("before"), error);
    if (!error) before_ = input_.operations;
  }
  std::filesystem::remove_all(at("cut"), ignored);
  for (const char* name : {"cut.yaml", "cut.stl", "cut.nc", "cut.progress"})
    std::filesystem::remove(at(name), ignored);
  // A new plan may take the place of these files while they are read.
  error.clear();
  std::filesystem::copy_file(input.job, at("cut.yaml"), error);
  if (!error) std::filesystem::create_hard_link(input.stl, at("cut.stl"), error);
  if (!error) std::filesystem::create_hard_link(input.program, at("cut.nc"), error);
  if (error) return fail(Code::kIo, folder_ + ": " + error.message());
  std::vector<std::string> words{program_, "verify",      at("cut.yaml"), at("cut.nc"),
                                 "--stl",  at("cut.stl"), "--machine",    input.machine,
                                 "--out",  at("cut"),     "--progress",   at("cut.progress")};
  if (!input.operation.empty()) words.insert(words.end(), {"--operation", input.operation});
  Result<ChildProcess> child = ChildProcess::start(words);
  if (!child) return tl::unexpected<Error>(child.error());
  child_.emplace(std::move(*child));
  ++id_;
  input_ = input;
  state_ = "working";
  error_.clear(), progress_.clear(), verdict_.clear(), verdicts_.clear();
  cancelled_ = false;
  tell_("cut", describe());
  return {};
}

Result<void> CutWork::cancel() {
  if (!child_) return fail(Code::kUsage, "no cut is in work");
  cancelled_ = true;
  child_->interrupt();
  return {};
}

/// The report is there whole, or not at all.
void CutWork::hear() {
  if (!child_ || !child_->listen()) return;
  const ChildEnd end = child_->end();
  child_.reset();
  bool done = true;
  for (const CutOperation& one : input_.operations) {
    std::ifstream in(path_of("cut", one, "report.json"));
    const json report = json::parse(in, nullptr, false);
    done = done && report.is_object();
    verdicts_.push_back(report.is_object() ? report.value("verdict", "") : "");
  }
  state_ = done ? "done" : cancelled_ ? "cancelled" : "refused";
  if (done) verdict_ = end.status == 0 ? "passed" : end.status == kIncomplete ? "incomplete" : "failed";
  if (state_ == "refused") error_ = last_words(end.text, "tiltfeed verify: ", folder_ + "/");
  tell_("cut", describe());
}

void CutWork::look() {
  if (!child_) return;
  std::ifstream in(at("cut.progress"));
  std::string line;
  if (!std::getline(in, line) || line == progress_) return;
  progress_ = line;
  tell_("cut", describe());
}

std::string CutWork::describe() const {
  if (id_ == 0) return "null";
  json about{{"id", id_}, {"plan", input_.plan_id}, {"state", state_}};
  if (!error_.empty()) about["error"] = error_;
  if (const auto now = parse_progress(progress_); now && state_ == "working")
    about["percent"] = now->percent, about["stage"] = now->stage;
  if (state_ == "done") {
    about["verdict"] = verdict_, about["before"] = !before_.empty();
    about["operations"] = json::array();
    for (std::size_t i = 0; i < verdicts_.size(); ++i)
      if (!input_.operations[i].name.empty())
        about["operations"].push_back({{"name", input_.operations[i].name},
                                       {"verdict", verdicts_[i]},
                                       {"before", find(before_, input_.operations[i].name) != nullptr}});
  }
  return about.dump(-1, ' ', true, json::error_handler_t::replace);
}

std::string CutWork::path_of(const char* folder, const CutOperation& operation, const char* name) const {
  return at(folder) + "/" + (operation.folder.empty() ? "" : operation.folder + "/") + name;
}

const CutOperation* CutWork::find(const std::vector<CutOperation>& operations, const std::string& name) {
  if (name.empty()) return operations.empty() ? nullptr : &operations.front();
  for (const CutOperation& one : operations)
    if (one.name == name) return &one;
  return nullptr;
}

Reply CutWork::file(const char* name, const char* type, const std::string& operation) const {
  if (state_ != "done") return refusal(409, "there is no cut that is done");
  const CutOperation* const one = find(input_.operations, operation);
  if (one == nullptr) return refusal(409, "the program that was cut has no operation of this name");
  Reply reply;
  reply.type = type;
  reply.file = path_of("cut", *one, name);
  return reply;
}

Reply CutWork::before(const std::string& operation) const {
  const CutOperation* const one = find(before_, operation);
  if (one == nullptr) return refusal(409, "there is no cut before");
  Reply reply;
  reply.type = kOctets;
  reply.file = path_of("before", *one, "cut.view");
  return reply;
}

}  // namespace tiltfeed::desk
