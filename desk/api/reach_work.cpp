#include "desk/api/reach_work.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/output_file.h"
#include "desk/http/access_check.h"
#include "desk/work/progress_text.h"

namespace tiltfeed::desk {

using nlohmann::json;

Result<std::uint64_t> ReachWork::say(const std::string& question) {
  if (!child_) {
    Result<ChildProcess> child = ChildProcess::start_talk({program_, "--answer-reach"});
    if (!child) return tl::unexpected<Error>(child.error());
    child_.emplace(std::move(*child));
  }
  if (!child_->say(question)) return fail(Code::kIo, "what answers is too busy; ask again");
  return asked_;
}

Result<std::uint64_t> ReachWork::ask(const AskedPart& part, const AskedJob& asked, const std::string& machine,
                                     bool exact) {
  const std::string number = std::to_string(++asked_);
  const std::string job = folder_ + "/reach-" + number + ".yaml";
  if (const Result<void> kept = config::write_file(job, asked.text); !kept)
    return tl::unexpected<Error>(kept.error());
  part_ = part.id;
  return say(json{
      {"do", "reach"},
      {"id", asked_},
      {"part", part.id},
      {"bodies", part.bodies},
      {"deviation", part.deviation},
      {"job", job},
      {"of", asked.id},
      {"operation", asked.operation},
      {"stl", part.stl},
      {"machine", machine},
      {"out", folder_ + "/reach-" + number + ".u8"},
      {"exact",
       exact}}.dump());
}

Result<std::uint64_t> ReachWork::fit(const AskedPart& part, const std::vector<std::uint32_t>& facets,
                                     double spread_deg) {
  return say(json{{"do", "fit"},
                  {"id", ++asked_},
                  {"part", part.id},
                  {"bodies", part.bodies},
                  {"deviation", part.deviation},
                  {"stl", part.stl},
                  {"unit_mm", part.unit_mm},
                  {"facets", facets},
                  {"spread_deg", spread_deg}}
                 .dump());
}

void ReachWork::hear() {
  if (!child_) return;
  const bool ended = child_->listen();
  for (const std::string& line : child_->take_lines()) take(line);
  if (!ended) return;
  // Whatever it died of, the next question starts another.
  const ChildEnd end = child_->end();
  child_.reset();
  told_ = json{{"id", asked_},
               {"state", "refused"},
               {"error", last_words(end.text, "tiltfeed-desk: ", folder_ + "/")}}
              .dump(-1, ' ', true, json::error_handler_t::replace);
  tell_("reach", told_);
}

void ReachWork::take(const std::string& line) {
  json answer = json::parse(line, nullptr, false);
  if (!answer.is_object()) return;
  const std::string what = answer.value("do", "");
  answer.erase("do");
  if (answer.contains("error")) answer["error"] = last_words(answer["error"], "tiltfeed: ", folder_ + "/");
  const std::string text = answer.dump(-1, ' ', true, json::error_handler_t::replace);
  if (what == "fit") return tell_("fit", text);
  answer["part"] = part_;
  if (answer.value("state", "") == "ready") {
    std::error_code ignored;
    if (!map_.empty()) std::filesystem::remove(map_, ignored);
    map_ = folder_ + "/reach-" + std::to_string(answer.value("id", std::uint64_t{0})) + ".u8";
  }
  told_ = answer.dump(-1, ' ', true, json::error_handler_t::replace);
  tell_("reach", told_);
}

Reply ReachWork::map() const {
  if (map_.empty()) return refusal(409, "nobody has asked what the tool reaches");
  Reply reply;
  reply.type = kOctets;
  reply.file = map_;
  return reply;
}

}  // namespace tiltfeed::desk
