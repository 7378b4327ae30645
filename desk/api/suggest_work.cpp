#include "desk/api/suggest_work.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "desk/work/progress_text.h"

namespace tiltfeed::desk {

using nlohmann::json;

Result<void> SuggestWork::start(const SuggestInput& input) {
  child_.reset();
  const std::string report = folder_ + "/suggest.json", progress = folder_ + "/suggest.progress";
  std::error_code ignored;
  for (const std::string& file : {report, progress}) std::filesystem::remove(file, ignored);
  std::vector<std::string> words{program_,    "suggest",     input.stl,  "--unit",     input.unit,
                                 "--machine", input.machine, "--cutter", input.cutter, "--report",
                                 report,      "--progress",  progress};
  for (const std::string& body : input.bodies) words.push_back("--body=" + body);
  Result<ChildProcess> child = ChildProcess::start(words);
  if (!child) return tl::unexpected<Error>(child.error());
  child_.emplace(std::move(*child));
  ++id_;
  input_ = input;
  state_ = "working";
  error_.clear(), progress_.clear(), found_.clear();
  cancelled_ = false;
  tell_("suggest", describe());
  return {};
}

Result<void> SuggestWork::cancel() {
  if (!child_) return fail(Code::kUsage, "nothing is being proposed");
  cancelled_ = true;
  child_->interrupt();
  return {};
}

void SuggestWork::hear() {
  if (!child_ || !child_->listen()) return;
  const ChildEnd end = child_->end();
  child_.reset();
  state_ = end.status == 0 ? "ready" : cancelled_ ? "cancelled" : "refused";
  if (state_ == "refused") error_ = last_words(end.text, "tiltfeed: ", folder_ + "/");
  if (state_ == "ready") {
    std::ostringstream text;
    text << std::ifstream(folder_ + "/suggest.json", std::ios::binary).rdbuf();
    found_ = text.str();
  }
  tell_("suggest", describe());
}

void SuggestWork::look() {
  if (!child_) return;
  std::ifstream in(folder_ + "/suggest.progress");
  std::string line;
  if (!std::getline(in, line) || line == progress_) return;
  progress_ = line;
  tell_("suggest", describe());
}

std::string SuggestWork::describe() const {
  if (id_ == 0) return "null";
  json about{{"id", id_}, {"part", input_.part_id}, {"cutter", input_.cutter}, {"state", state_}};
  if (!error_.empty()) about["error"] = error_;
  if (const auto at = parse_progress(progress_); at && state_ == "working")
    about["percent"] = at->percent, about["stage"] = at->stage;
  const json found = json::parse(found_, nullptr, false);
  if (found.is_object()) {
    about["proposals"] = found.value("proposals", json::array());
    about["seconds"] = found.value("seconds", 0.0);
  }
  return about.dump(-1, ' ', true, json::error_handler_t::replace);
}

}  // namespace tiltfeed::desk
