#include "pathgen/lean/leaned_passes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "pathgen/lean/lean_choice.h"
#include "pathgen/options/rest_reason.h"

namespace tiltfeed::pathgen {

namespace {

/// Axes nearer to the mode's than this, rad, do not lean.
constexpr double kStandsUpright = 1e-9;
/// A join is looked at in so many pieces at least.
constexpr double kPlacesOfJoin = 4.0;
/// Runs meet within this, mm.
constexpr double kMeet = 1e-9;

struct Leaned {
  std::vector<Pass> pieces;
  bool changed = false;
  LeanFigures figures;
};

/// One pass.
class PassLeaner {
 public:
  PassLeaner(const LeanTool& tool, const Mesh& fixtures, const Pass& pass)
      : tool_(tool), fixtures_(fixtures), frames_(pass, tool.map()) {}

  Leaned run() {
    const std::vector<LeanStretch> needed = stretches();
    if (needed.empty()) return {};
    out_.changed = true;
    double at = 0.0;
    for (const LeanStretch& stretch : needed) {
      if (stretch.from > at) add(upright(at, stretch.from));
      for (LeanedRun& run : lean_along(tool_, frames_, stretch, lean_spacing(tool_))) add(std::move(run));
      at = stretch.to;
    }
    if (frames_.length() > at) add(upright(at, frames_.length()));
    finish();
    return std::move(out_);
  }

 private:
  /// Where the tool may not stay upright, each with room to lean on and off.
  std::vector<LeanStretch> stretches() {
    const Lean& lean = tool_.options().lean;
    const double radius = tool_.options().cutter.radius(),
                 room = lean.limit.radians() / lean.max_turn.radians() + lean_spacing(tool_);
    std::vector<LeanStretch> found;
    const auto add = [&](double from, double to) {
      from = std::max(0.0, from - room), to = std::min(frames_.length(), to + room);
      if (!found.empty() && from <= found.back().to)
        found.back().to = std::max(found.back().to, to);
      else
        found.push_back({from, to});
    };
    const std::vector<LeanStation> places = frames_.between(0.0, frames_.length(), radius);
    if (places.size() == 1 && tool_.held(places[0].point, hint_)) add(0.0, 0.0);
    for (std::size_t i = 1; i < places.size(); ++i)
      if (!tool_.clear_upright(places[i - 1].point, places[i].point, hint_))
        add(places[i - 1].run, places[i].run);
    for (LeanStretch& stretch : found) {
      if (stretch.from > 0.0) stretch.first = LeanAngle{};
      if (stretch.to < frames_.length()) stretch.last = LeanAngle{};
    }
    return found;
  }

  LeanedRun upright(double from, double to) const {
    LeanedRun run;
    for (const LeanStation& s : frames_.between(from, to, std::numeric_limits<double>::infinity()))
      run.push_back({s, {}});
    return run;
  }

  /// Joined to the last one where that ends there with the same lean.
  void add(LeanedRun run) {
    if (!runs_.empty() && std::abs(runs_.back().back().station.run - run.front().station.run) <= kMeet &&
        runs_.back().back().lean == run.front().lean) {
      runs_.back().insert(runs_.back().end(), run.begin() + 1, run.end());
      return;
    }
    runs_.push_back(std::move(run));
  }

  /// From its ends as much of the run is cut as has no way up.
  void find_ways(LeanedRun& run) const {
    const auto has_way = [this](const LeanedPlace& place) {
      EnvelopePoint p = place.station.point;
      p.axis = place.axis();
      return place.lean == LeanAngle{} || leaned_end(tool_, p).has_value();
    };
    while (!run.empty() && !has_way(run.back())) run.pop_back();
    const auto first = std::find_if(run.begin(), run.end(), has_way);
    run.erase(run.begin(), first);
  }

  void finish() {
    double at = 0.0;
    for (LeanedRun& run : runs_) {
      find_ways(run);
      if (run.size() < 2) continue;
      leave_out(at, run.front().station.run);
      at = std::max(at, run.back().station.run);
      for (std::size_t i = 1; i < run.size(); ++i) {
        const double size = std::max(run[i - 1].lean.size(), run[i].lean.size());
        if (size > 0.0) out_.figures.leaned += run[i].station.run - run[i - 1].station.run;
        out_.figures.largest = std::max(out_.figures.largest, size);
      }
      out_.pieces.push_back(pass_of(tool_, frames_, thinned_run(tool_, frames_, run, hint_)));
    }
    leave_out(at, frames_.length());
  }

  /// Of each place on the way what holds the tool there; of the others, what held it last.
  void leave_out(double from, double to) {
    if (to - from <= kMeet && frames_.length() > 0.0) return;
    out_.figures.left += to - from;
    const std::vector<LeanStation> places = frames_.between(from, to, lean_spacing(tool_));
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto held = tool_.held(places[i].point, hint_);
      if (!held) continue;
      HeldBy& by = held->of_fixtures                ? out_.figures.fixtures[fixtures_.source[held->facet]]
                   : held->part == ToolPart::kShank ? out_.figures.shank
                                                    : out_.figures.holder;
      if (by.places++ == 0) by.first = places[i].point.centre;
      if (i > 0) by.length += places[i].run - places[i - 1].run;
      by.facets.push_back(held->facet);
    }
  }

  const LeanTool& tool_;
  const Mesh& fixtures_;
  PassFrames frames_;
  std::vector<LeanedRun> runs_;
  Leaned out_;
  std::uint32_t hint_ = kNoFacet;
};

void add_to(HeldBy& sum, const HeldBy& more) {
  if (sum.places == 0) sum.first = more.first;
  sum.places += more.places, sum.length += more.length;
  sum.facets.insert(sum.facets.end(), more.facets.begin(), more.facets.end());
}

void sort_facets(HeldBy& by) {
  std::sort(by.facets.begin(), by.facets.end());
  by.facets.erase(std::unique(by.facets.begin(), by.facets.end()), by.facets.end());
}

}  // namespace

LeanFigures lean_passes(const LeanTool& tool, std::vector<std::vector<Pass>>& rows,
                        const ReportShare& report) {
  std::vector<std::pair<std::size_t, std::size_t>> all;
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (std::size_t k = 0; k < rows[row].size(); ++k)
      if (!rows[row][k].empty()) all.push_back({row, k});
  const Mesh none;
  const Mesh& fixtures = tool.options().fixtures ? tool.options().fixtures->mesh : none;
  std::vector<Leaned> leaned(all.size());
  Watch watch(report, all.size());
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    if (watch.next()) leaned[i] = PassLeaner(tool, fixtures, rows[all[i].first][all[i].second]).run();
  });
  std::vector<std::vector<Pass>> out(rows.size());
  LeanFigures sum;
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<Pass>& row = out[all[i].first];
    if (!leaned[i].changed) {
      row.push_back(std::move(rows[all[i].first][all[i].second]));
      continue;
    }
    for (Pass& piece : leaned[i].pieces) row.push_back(std::move(piece));
    const LeanFigures& f = leaned[i].figures;
    sum.leaned += f.leaned, sum.left += f.left, sum.largest = std::max(sum.largest, f.largest);
    add_to(sum.shank, f.shank), add_to(sum.holder, f.holder);
    for (const auto& [body, by] : f.fixtures) add_to(sum.fixtures[body], by);
  }
  sort_facets(sum.shank), sort_facets(sum.holder);
  for (auto& [body, by] : sum.fixtures) sort_facets(by);
  rows = std::move(out);
  return sum;
}

std::optional<LeanedEnd> leaned_end(const LeanTool& tool, const EnvelopePoint& end) {
  const Deformation& map = tool.map();
  if (angle_between(map.axis_at(end.centre), end.axis) <= kStandsUpright) return std::nullopt;
  const ToolStand top{end.centre + end.axis * tool.way_back(end, end.axis), end.axis};
  const Point<Flat> flat = map.flatten(top.centre);
  const AxisLine line = map.axis_line(flat.x, flat.y);
  const ToolStand over{line.base + line.axis * tool.clearance_z(), line.axis};
  if (!tool.clear_off_part(top, over)) return std::nullopt;
  return LeanedEnd{top.centre, {flat.x, flat.y, tool.clearance_z()}};
}

std::optional<Pass> leaned_join(const LeanTool& tool, const EnvelopePoint& a, const Pass& between,
                                const EnvelopePoint& b) {
  const auto upright = [&](EnvelopePoint p) {
    p.axis = tool.map().axis_at(p.centre);
    return p;
  };
  Pass whole{upright(a)};
  whole.insert(whole.end(), between.begin(), between.end());
  whole.push_back(upright(b));
  const PassFrames frames(whole, tool.map());
  const auto lean_at = [](const LeanStation& s, Vec3 axis) {
    const LeanAngle lean = s.lean_of(axis);
    return lean.size() <= kStandsUpright ? LeanAngle{} : lean;
  };
  const LeanAngle from = lean_at(frames.points().front(), a.axis),
                  to = lean_at(frames.points().back(), b.axis);
  const double turn = std::hypot(to.u - from.u, to.v - from.v);
  if (frames.length() <= kMeet || turn > tool.options().lean.max_turn.radians() * frames.length())
    return std::nullopt;
  const std::vector<LeanedRun> runs =
      lean_along(tool, frames, {0.0, frames.length(), from, to},
                 std::min(lean_spacing(tool), frames.length() / kPlacesOfJoin));
  if (runs.size() != 1 || runs[0].front().station.run > 0.0 || runs[0].back().station.run < frames.length())
    return std::nullopt;
  std::uint32_t hint = kNoFacet;
  Pass pass = pass_of(tool, frames, thinned_run(tool, frames, runs[0], hint));
  return Pass(pass.begin() + 1, pass.end() - 1);
}

}  // namespace tiltfeed::pathgen
