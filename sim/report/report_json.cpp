#include <array>
#include <cmath>
#include <cstdio>

#include "sim/report/report.h"

namespace tiltfeed::sim {
namespace {

/// Objects and arrays with indents; numbers with fixed decimals, so that the same run gives the same bytes.
class Json {
 public:
  void open(const char* key, char bracket) {
    begin(key);
    text_ += bracket;
    closing_ += bracket == '{' ? '}' : ']';
    fresh_ = true;
  }
  void close() {
    const char bracket = closing_.back();
    closing_.pop_back();
    if (!fresh_) text_ += "\n" + std::string(closing_.size() * 2, ' ');
    text_ += bracket;
    fresh_ = false;
  }
  void put(const char* key, double value, int decimals = 6) {
    begin(key);
    std::array<char, 400> number;
    std::snprintf(number.data(), number.size(), "%.*f", decimals, value);
    text_ += std::isfinite(value) ? number.data() : "null";
  }
  void put(const char* key, std::uint64_t value) {
    begin(key);
    text_ += std::to_string(value);
  }
  void put(const char* key, const std::string& value) {
    begin(key);
    text_ += '"';
    for (const char c : value) {
      std::array<char, 8> escape;
      std::snprintf(escape.data(), escape.size(), "\\u%04x", static_cast<unsigned char>(c));
      if (static_cast<unsigned char>(c) < 0x20)
        text_ += escape.data();
      else
        text_ += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    }
    text_ += '"';
  }
  void put(const char* key, const char* value) { put(key, std::string(value)); }
  void put(const char* key, bool value) {
    begin(key);
    text_ += value ? "true" : "false";
  }
  std::string finish() { return text_ + "\n"; }

 private:
  void begin(const char* key) {
    if (!closing_.empty()) text_ += (fresh_ ? "\n" : ",\n") + std::string(closing_.size() * 2, ' ');
    if (key != nullptr) text_ += '"' + std::string(key) + "\": ";
    fresh_ = false;
  }
  std::string text_, closing_;
  bool fresh_ = true;
};

void put_point(Json& json, const char* key, Point<Part> p) {
  json.open(key, '[');
  for (const double v : {p.x, p.y, p.z}) json.put(nullptr, v, 4);
  json.close();
}

void put_trouble(Json& json, const char* key, const Trouble& t) {
  json.open(key, '{');
  json.put("kind", std::string(kTroubleNames[static_cast<int>(t.kind)]));
  json.put("tool", std::string(kToolPartNames[static_cast<int>(t.tool)]));
  json.put("depth_mm", t.depth);
  json.put("block", t.block);
  json.put("line", std::uint64_t{t.line});
  if (t.facet != kNoFacet) json.put("facet", std::uint64_t{t.facet});
  put_point(json, "place_mm", t.place);
  json.put("time_s", t.time, 3);
  json.put("moves", std::uint64_t{t.last_move} - t.first_move + 1);
  json.close();
}

void put_troubles(Json& json, const Removal& r) {
  json.open("troubles", '[');
  for (const Trouble& t : r.troubles) put_trouble(json, nullptr, t);
  json.close();
}

/// Feed moves that are faster at the tip than the job's feeds.
void put_haste(Json& json, const Removal& r) {
  json.open("too_fast", '{');
  json.put("moves", r.haste.moves);
  if (r.haste.moves > 0) {
    json.put("feed_mm_per_min", r.haste.feed, 3);
    json.put("block", r.haste_block);
    json.put("line", std::uint64_t{r.haste_line});
    put_point(json, "place_mm", r.haste.place);
  }
  json.close();
}

/// Where most is left.
void put_most_left(Json& json, const Removal& r) {
  json.open("most_left", '[');
  for (const Leftover& l : r.most_left) {
    json.open(nullptr, '{');
    json.put("left_mm", l.left);
    json.put("block", l.block);
    json.put("line", std::uint64_t{l.line});
    json.put("facet", std::uint64_t{l.facet});
    put_point(json, "place_mm", l.place);
    json.put("time_s", l.time, 3);
    json.close();
  }
  json.close();
}

void put_axes(Json& json, const Removal& r, const MachineModel& m) {
  const std::array<std::string, 5> names{"X", "Y", "Z", std::string(1, m.tilt.letter),
                                         std::string(1, m.rotary.letter)};
  json.open("travel", '{');
  for (std::size_t k = 0; k < names.size(); ++k) {
    json.open(names[k].c_str(), '{');
    const std::string unit = k < 3 ? "_mm" : "_deg";
    json.put(("least" + unit).c_str(), r.travel_low[k], 4);
    json.put(("most" + unit).c_str(), r.travel_high[k], 4);
    double speed = 0.0;
    for (const TimeBin& bin : r.bins) speed = std::max(speed, bin.speed[k]);
    json.put(("speed" + unit + "_per_min").c_str(), speed, 3);
    json.close();
  }
  json.close();
}

void put_excess(Json& json, const Removal& r) {
  json.open("left_on_part", '{');
  json.put("surface_mm2", r.area, 3);
  json.put("surface_reached_mm2", r.touched_area, 3);
  json.put("saturated_at_mm", r.reach);
  json.put("probes", r.probes);
  json.put("probes_reached", r.touched);
  json.put("least_mm", r.deepest);
  for (std::size_t k = 0; k < kPercentiles.size(); ++k)
    json.put(("percentile_" + std::to_string(static_cast<int>(kPercentiles[k])) + "_mm").c_str(),
             r.excess[k]);
  json.close();
}

}  // namespace

namespace {

/// What the tool reaches and the program leaves.
void put_rest(Json& json, const Rest& rest, const RemovalVerdict& verdict) {
  json.open("rest", '{');
  json.put("incomplete", !verdict.rest.empty());
  json.put("area_mm2", rest.area, 3);
  json.put("out_of_reach_mm2", rest.out_of_reach, 3);
  if (rest.elsewhere > 0.0) json.put("other_directions_mm2", rest.elsewhere, 3);
  if (rest.between_passes > 0.0)
    json.put("between_passes_mm2", rest.between_passes, 3), json.put("passes_apart_mm", rest.apart);
  json.put("limit_mm", rest.limit);
  if (rest.facet != kNoFacet) {
    json.put("most_left_mm", rest.left);
    json.put("never_cut", rest.never_cut);
    json.put("facet", static_cast<std::uint64_t>(rest.facet));
    json.put("x_mm", rest.place.x), json.put("y_mm", rest.place.y), json.put("z_mm", rest.place.z);
  }
  json.close();
}

}  // namespace

std::string to_json(const RemovalContext& context, const Removal& r, const RemovalVerdict& verdict) {
  Json json;
  json.open(nullptr, '{');
  json.put("passed", verdict.passed());
  json.put("verdict", verdict.passed() ? "passed" : verdict.incomplete() ? "incomplete" : "failed");
  json.open("failures", '[');
  for (const std::string& failure : verdict.failures) json.put(nullptr, failure);
  json.close();
  if (!context.job.operation.name.empty()) json.put("operation", context.job.operation.name);
  json.put("part", context.job.plan.name);
  json.put("machine", context.job.machine.model.name);
  json.put("source", context.source);
  json.put("stock", to_string(context.stock));
  if (!context.stock_from.empty()) json.put("stock_from", context.stock_from);
  json.put("resolution_mm", r.cell);
  if (!verdict.unseen.empty()) json.put("not_seen", verdict.unseen);
  json.put("tolerance_mm", verdict.tolerance);
  json.put("gouge_mm", verdict.gouge);
  if (r.gouge.depth > 0.0) put_trouble(json, "deepest_gouge", r.gouge);
  json.put("rapid_overlap_mm", r.worst[static_cast<int>(TroubleKind::kRapidPart)]);
  json.put("excess_limit_mm", verdict.excess_limit);
  put_rest(json, r.rest, verdict);
  put_excess(json, r);
  json.put("blocks", r.blocks);
  json.put("machining_seconds", r.seconds, 3);
  if (context.header.seconds) json.put("posted_seconds", *context.header.seconds, 3);
  json.put("feed_seconds", r.feed_seconds, 3);
  json.put("rapid_seconds", r.rapid_seconds, 3);
  json.put("air_cut_seconds", r.air_seconds, 3);
  json.put("air_cut_share", r.feed_seconds > 0.0 ? r.air_seconds / r.feed_seconds : 0.0);
  json.put("feed_length_mm", r.feed_length, 3);
  json.put("rapid_length_mm", r.rapid_length, 3);
  json.put("stock_mm3", r.stock_volume, 3);
  json.put("removed_mm3", r.stock_volume - r.left_volume, 3);
  json.put("left_mm3", r.left_volume, 3);
  put_axes(json, r, context.job.machine.model);
  put_troubles(json, r);
  put_haste(json, r);
  put_most_left(json, r);
  json.put("removal_bin_s", r.bin_seconds, 6);
  json.open("removed_by_bin_mm3", '[');
  for (const TimeBin& bin : r.bins) json.put(nullptr, bin.removed, 4);
  json.close();
  json.close();
  return json.finish();
}

}  // namespace tiltfeed::sim
