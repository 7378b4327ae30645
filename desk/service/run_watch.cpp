#include "desk/service/run_watch.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "desk/service/program_text.h"
#include "desk/service/tool_place.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kLinesBefore = 4, kLines = 12;  // of the text around the running line

std::string text_of(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

std::string words_in(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::uint64_t count_in(const ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

/// The words of "state    Alarm: ..." of a status for people.
std::string state_words(const std::string& text) {
  constexpr std::string_view kMark = "state";
  if (text.rfind(kMark, 0) != 0) return {};
  const std::size_t begin = text.find_first_not_of(' ', kMark.size());
  return begin == std::string::npos ? "" : text.substr(begin, text.find('\n') - begin);
}

/// Each rotary word as an angle within half a turn, and the whole turns beside it.
ordered_json unwound(const ordered_json& program) {
  ordered_json all = ordered_json::object();
  for (const char* letter : {"A", "B", "C"}) {
    const auto found = program.find(letter);
    if (found == program.end() || !found->is_number()) continue;
    const double word = found->get<double>(), angle = std::remainder(word, 360.0);
    all[letter] = {{"angle", angle}, {"turns", std::lround((word - angle) / 360.0)}};
  }
  return all;
}

}  // namespace

struct RunWatch::State {
  State(ServiceLink& its_link, WatchCalls its_calls) : link(its_link), calls(std::move(its_calls)) {}

  ServiceLink& link;
  WatchCalls calls;
  bool up = false;
  std::string error;  // why it is lost; empty: it was not asked yet
  ordered_json machine = nullptr, wire = nullptr, reset = nullptr, order = nullptr, scene = nullptr;
  ordered_json list = ordered_json::array();
  ordered_json change = nullptr;  // the job that waits for a tool change, as `list` has it
  ordered_json job = nullptr;     // on the machine, as `show` has it
  ordered_json status = nullptr;  // as `machine status` has it
  bool live = false;              // the status is of the run
  std::uint64_t running = 0, floor = 0;
  std::string files;
  std::optional<ProgramText> text;
  bool indexing = false;
  std::optional<Placing> placing;
  Time next_list, next_run, asked_list, asked_show;
  bool listing = false, showing = false;
  std::string told_run, told_jobs;
  std::uint64_t version = 0;  // of the jobs

  void lose(const std::string& why) {
    up = false;
    error = why;
    running = 0;
    live = false;
    job = status = change = nullptr;
    files.clear();
    text.reset();
    placing.reset();
  }

  void begin_run(std::uint64_t number) {
    running = number;
    job = nullptr;
    status = nullptr;
    files.clear();
    text.reset();
    placing.reset();
    next_run = {};
  }

  void take_list(const std::string& reply, RunWatch& watch) {
    const ordered_json said = ordered_json::parse(reply, nullptr, false);
    const bool was_lost = !up;
    up = true;
    error.clear();
    machine = said.value("machine", ordered_json());
    wire = said.value("link", ordered_json());
    reset = said.value("reset", ordered_json());
    list = said.value("jobs", ordered_json::array());
    const std::uint64_t newest = list.empty() ? 0 : count_in(list.back(), "job");
    if (said.value("more", false))
      floor = newest;  // not all of them yet: on from there
    else if (newest > kJobs + floor)
      floor = newest - kJobs;
    std::uint64_t now = 0;
    change = nullptr;
    for (const ordered_json& one : list) {
      const std::string is = words_in(one, "state");
      if (is == "running") now = count_in(one, "job");
      if (is == "tool change") change = one;
      if (is == "running" || is == "tool change") floor = std::min(floor, count_in(one, "job") - 1);
    }
    const bool changed = now != running;
    if (changed) begin_run(now);
    if (changed && now == 0) live = false;
    if (watch.turned && (was_lost || changed)) watch.turned();
  }

  void take_show(const std::string& reply) {
    ordered_json said = ordered_json::parse(reply, nullptr, false);
    if (count_in(said, "job") != running) return;
    if (files.empty()) open_files(words_in(said, "folder"));
    for (const char* key : {"v", "ok", "folder"}) said.erase(key);
    if (words_in(said, "state") != "running") next_list = {};  // it has ended: the list says how
    ordered_json about = said;
    about["state"] = words_in(said, "machine");
    about.erase("machine");
    status = place_of(about);
    live = true;
    for (const char* key : {"program", "override", "words"}) said.erase(key);
    job = std::move(said);
  }

  void open_files(const std::string& folder) {
    files = folder;
    if (folder.empty()) return;
    if (Result<ProgramText> opened = ProgramText::open(folder + "/program.nc"); opened)
      text = std::move(*opened), indexing = true;
    if (calls.placing) placing = calls.placing(running, folder);
  }

  /// What is said of place and state, by a run or by `machine status`.
  ordered_json place_of(const ordered_json& said) const {
    ordered_json place = ordered_json::object();
    for (const char* key : {"state", "alarm", "inputs", "machine", "program", "override", "words"})
      if (said.contains(key)) place[key] = said[key];
    if (!place.contains("program") || !place["program"].is_object()) return place;
    place["rotaries"] = unwound(place["program"]);
    if (!placing) return place;
    AxisPlaces axes;
    for (const auto& [letter, value] : place["program"].items())
      if (value.is_number()) axes[letter] = value.get<double>();
    if (const auto pose = tool_place(axes, placing->machine, placing->of(words_in(said, "operation"))))
      place["tool"] = {{"tip", {pose->tip.x, pose->tip.y, pose->tip.z}},
                       {"axis", {pose->axis.x, pose->axis.y, pose->axis.z}}};
    return place;
  }

  ordered_json lines() const {
    if (!text || !job.is_object()) return nullptr;
    const auto range = job.find("uncertain_lines");
    const std::uint64_t line =
        range != job.end() && range->is_array() && !range->empty() && (*range)[0].is_number_unsigned()
            ? (*range)[0].get<std::uint64_t>()
            : 0;
    if (line == 0) return nullptr;
    const std::uint64_t first = line > kLinesBefore ? line - kLinesBefore : 1;
    return {{"line", line}, {"first", first}, {"lines", text->lines(first, kLines)}};
  }

  ordered_json whole() const {
    return {{"service", !link.is_named() ? "none"
                        : up             ? "up"
                        : error.empty()  ? "asked"
                                         : "lost"},
            {"error", error},
            {"machine", machine},
            {"link", wire},
            {"reset", reset},
            {"job", job.is_object() || running == 0 ? job : ordered_json{{"job", running}}},
            {"tool_change", change},
            {"status", status},
            {"live", live},
            {"order", order},
            {"scene", scene},
            {"text", lines()}};
  }

  void tell() {
    const std::string jobs = text_of(list);
    if (jobs != told_jobs) {
      told_jobs = jobs;
      calls.tell("jobs", "{\"version\": " + std::to_string(++version) + "}");
    }
    std::string run = text_of(whole());
    if (run == told_run) return;
    told_run = std::move(run);
    calls.tell("run", told_run);
  }
};

RunWatch::RunWatch(ServiceLink& link, WatchCalls calls)
    : state_(std::make_unique<State>(link, std::move(calls))) {}
RunWatch::~RunWatch() = default;

void RunWatch::look(Time now) {
  State& s = *state_;
  if (!s.link.is_named()) return;
  const bool silent =
      (s.listing && now - s.asked_list >= kSilence) || (s.showing && now - s.asked_show >= kSilence);
  if (silent && s.up)
    s.lose("it has not answered for " + std::to_string(kSilence.count() / 1000) + " s"), s.tell();
  const auto answer = [&s](bool& in_work, auto take) {
    return [&s, &in_work, take](const Result<std::string>& reply) {
      in_work = false;
      if (reply)
        take(*reply);
      else if (reply.error().code == Code::kIo && (s.up || s.error.empty()))
        s.lose(reply.error().message);
      s.tell();
    };
  };
  if (s.text && s.indexing) s.indexing = s.text->read_on();
  if (!s.listing && now >= s.next_list) {
    s.listing = true, s.asked_list = now, s.next_list = now + kIdlePeriod;
    s.link.ask(text_of({{"v", 1}, {"op", "list"}, {"job", s.floor}}),
               answer(s.listing, [this](const std::string& reply) { state_->take_list(reply, *this); }));
  }
  if (s.running == 0 || now < s.next_run) return;
  if (s.showing) return;
  s.next_run = now + kRunPeriod;
  s.showing = true, s.asked_show = now;
  s.link.ask(text_of({{"v", 1}, {"op", "show"}, {"job", s.running}}),
             answer(s.showing, [&s](const std::string& reply) { s.take_show(reply); }));
}

int RunWatch::patience_ms(Time now) const {
  const State& s = *state_;
  if (!s.link.is_named()) return -1;
  if (s.indexing) return 0;
  const Time next = s.running != 0 ? std::min(s.next_list, s.next_run) : s.next_list;
  return static_cast<int>(std::clamp<std::int64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(next - now).count() + 1, 0, kIdlePeriod.count()));
}

void RunWatch::note_status(const std::string& reply) {
  if (state_->running != 0) return;
  const ordered_json said = ordered_json::parse(reply, nullptr, false);
  if (!said.is_object() || !said.contains("result") || !said["result"].is_object() ||
      !said["result"].contains("state"))
    return;
  state_->status = state_->place_of(said["result"]);
  if (const std::string words = state_words(words_in(said, "text")); !words.empty())
    state_->status["words"] = words;
  state_->live = false;
  state_->tell();
}

void RunWatch::note_order(const std::string& order) {
  state_->order = ordered_json::parse(order, nullptr, false);
  state_->tell();
}

void RunWatch::note_scene(const std::string& scene) {
  state_->scene = ordered_json::parse(scene, nullptr, false);
  state_->tell();
}

std::uint64_t RunWatch::job() const { return state_->running; }

const std::string& RunWatch::folder() const { return state_->files; }

std::string RunWatch::describe() const { return text_of(state_->whole()); }

std::string RunWatch::jobs() const {
  return "{\"version\": " + std::to_string(state_->version) + ", \"jobs\": " + text_of(state_->list) + "}";
}

}  // namespace tiltfeed::desk
