#include "sim/report/cut_view.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "sim/basics/text.h"
#include "sim/collision/machine_view.h"
#include "sim/motion/forward.h"
#include "sim/solid/tool_solid.h"
#include "sim/viewer/packed_view.h"

namespace tiltfeed::sim {
namespace {

using nlohmann::json;

// Amounts are whole multiples of this, mm, or of more where they would not fit.
constexpr double kAmountUnit = 1e-4, kMostUnits = 30000.0;
constexpr std::int16_t kNeverCut = -32768;
// Times are shares of the run.
constexpr double kTimes = 65534.0;
constexpr std::uint16_t kNeverTime = 65535;
constexpr std::size_t kPoses = 4000;              // of the tool over the run
constexpr std::size_t kMostMachine = 16'000'000;  // bytes of machine and fixtures: 440,000 facets
constexpr std::size_t kOutline = 24;              // heights of a piece of the tool

json place_json(Point<Part> p) { return {p.x, p.y, p.z}; }

/// Where the tool is when.
class Poses {
 public:
  Poses(const config::Job& job, const ExecutedPath& path)
      : chain_(job.machine.model, job.setup), path_(path) {}
  Pose at(double time) const { return chain_(words_at(time)); }
  /// X Y Z of the slides and both rotaries.
  Joints words_at(double time) const {
    const auto& moves = path_.moves;
    const auto found = std::lower_bound(moves.begin(), moves.end(), time,
                                        [](const ExecutedMove& m, double t) { return m.end < t; });
    const std::size_t move = std::min(static_cast<std::size_t>(found - moves.begin()), moves.size() - 1);
    const ExecutedMove& m = moves[move];
    const double share = m.end > m.start ? std::clamp((time - m.start) / (m.end - m.start), 0.0, 1.0) : 1.0;
    return between(path_.from(move), m.to, share);
  }

 private:
  FrameChain chain_;
  const ExecutedPath& path_;
};

/// Outlines of the tool's pieces: radius and height over the tip, from below.
json tool_json(const pathgen::Cutter& cutter) {
  const ToolSolid solid(cutter, {}, 0.0);
  json pieces = json::array();
  for (const ToolPart part : kToolParts) {
    for (const Revolved& piece : solid.pieces(part)) {
      const Corner &first = piece.corners().front(), &last = piece.corners().back();
      const double low = first.h - first.radius, high = last.h + last.radius;
      json outline = json::array();
      for (std::size_t i = 0; i <= kOutline; ++i) {
        // Closer at both ends, where it is round.
        const double share = 0.5 - 0.5 * std::cos(3.14159265358979 * static_cast<double>(i) / kOutline);
        const double h = low + (high - low) * share;
        const double inner = std::clamp(h, low + 1e-6, high - 1e-6);
        outline.push_back({std::max(0.0, piece.radius_at(inner)), h});
      }
      pieces.push_back({{"part", kToolPartNames[static_cast<std::size_t>(part)]}, {"outline", outline}});
    }
  }
  return pieces;
}

void add_mesh(PackedView& view, const Patches& patches) {
  std::vector<float> corners;
  std::vector<std::uint32_t> facets;
  corners.reserve(3 * patches.mesh.vertices.size()), facets.reserve(3 * patches.mesh.facets.size());
  for (const Point<Part> p : patches.mesh.vertices)
    for (const double x : {p.x, p.y, p.z}) corners.push_back(static_cast<float>(x));
  for (const auto& facet : patches.mesh.facets) facets.insert(facets.end(), facet.begin(), facet.end());
  view.add("corners", std::span<const float>(corners));
  view.add_steps("facets", facets);
  view.add_steps("source", patches.mesh.source);
}

/// What is left on each patch, mean, least and most. Returns the unit, mm.
double add_amounts(PackedView& view, const Removal& r) {
  const double unit = std::max(kAmountUnit, r.reach / kMostUnits);
  const std::array<std::pair<const char*, const std::vector<float>*>, 3> all{
      {{"mean", &r.patch_mean}, {"least", &r.patch_low}, {"most", &r.patch_high}}};
  for (const auto& [name, values] : all) {
    std::vector<std::int16_t> amounts(values->size(), kNeverCut);
    for (std::size_t i = 0; i < amounts.size(); ++i) {
      const double value = static_cast<double>((*values)[i]);
      if (!std::isnan(static_cast<double>(r.patch_mean[i])) && std::isfinite(value))
        amounts[i] =
            static_cast<std::int16_t>(std::lround(std::clamp(value / unit, -kMostUnits, kMostUnits)));
    }
    view.add(name, std::span<const std::int16_t>(amounts));
  }
  return unit;
}

/// When each patch was cut last, and by which line.
void add_cuts(PackedView& view, const Probes& probes, const ExecutedPath& path) {
  const Patches& patches = probes.patches();
  const std::size_t count = patches.mesh.facets.size();
  const double begin = path.moves.front().start, span = path.moves.back().end - begin;
  std::vector<std::uint16_t> times(count, kNeverTime);
  std::vector<std::uint32_t> lines(count, 0);
  for (std::size_t p = 0; p < count; ++p) {
    std::uint32_t last = Probes::kNever;
    for (std::uint64_t i = patches.first[p]; i < patches.first[p + 1]; ++i) {
      const std::uint32_t move = probes.value(i).move;
      if (move != Probes::kNever && (last == Probes::kNever || move > last)) last = move;
    }
    if (last == Probes::kNever) continue;
    const double share = span > 0.0 ? (path.moves[last].end - begin) / span : 1.0;
    times[p] = static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * kTimes));
    lines[p] = path.moves[last].line;
  }
  view.add("time", std::span<const std::uint16_t>(times));
  view.add_steps("line", lines);
}

/// The tool at equal spans of time, tip and axis, and the words of the axes then.
void add_poses(PackedView& view, const Poses& poses, const ExecutedPath& path) {
  const double begin = path.moves.front().start, span = path.moves.back().end - begin;
  std::vector<float> numbers, words;
  for (std::size_t i = 0; i <= kPoses; ++i) {
    const double time = begin + span * static_cast<double>(i) / static_cast<double>(kPoses);
    const Joints at = poses.words_at(time);
    for (const double x : {at.x, at.y, at.z, at.a, at.c}) words.push_back(static_cast<float>(x));
    const Pose pose = poses.at(time);
    for (const double x : {pose.tip.x, pose.tip.y, pose.tip.z, pose.axis.x, pose.axis.y, pose.axis.z})
      numbers.push_back(static_cast<float>(x));
  }
  view.add("poses", std::span<const float>(numbers));
  view.add("words", std::span<const float>(words));
}

/// Machine and fixtures. Not shown: those that cannot be read, or that no page would take.
void add_machine(PackedView& view, const config::Job& job) {
  const auto bytes = machine_view(job);
  if (!bytes || bytes->size() > kMostMachine || bytes->size() % sizeof(float) != 0) return;
  std::vector<float> numbers(bytes->size() / sizeof(float));
  std::memcpy(numbers.data(), bytes->data(), bytes->size());
  view.add("machine", std::span<const float>(numbers));
}

/// Frames as differences from the one before: what is not cut is nothing.
json add_film(PackedView& view, const StockFilm& film) {
  std::vector<std::uint16_t> all;
  const std::vector<std::uint16_t>* before = nullptr;
  for (const auto& frame : film.frames()) {
    for (std::size_t i = 0; i < frame.size(); ++i)
      all.push_back(static_cast<std::uint16_t>(frame[i] - (before ? (*before)[i] : 0)));
    before = &frame;
  }
  view.add("film", std::span<const std::uint16_t>(all));
  return {{"axis", film.axis()},      {"cell_mm", film.cell()}, {"size", film.size()},
          {"first_mm", film.first()}, {"span_mm", film.span()}, {"frames", film.frames().size()}};
}

json places_json(const CutViewParts& p, const Poses& poses) {
  json all = json::array();
  const std::vector<WorstPlace> places = worst_places(p.removal, p.verdict);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const WorstPlace& w = places[i];
    const Pose tool = poses.at(w.time);
    json one{{"what", w.what},
             {"amount", w.amount},
             {"wrong", w.wrong},
             {"block", w.block},
             {"line", w.line},
             {"place", place_json(w.place)},
             {"time", w.time},
             {"tip", place_json(tool.tip)},
             {"axis", {tool.axis.x, tool.axis.y, tool.axis.z}}};
    if (w.facet != kNoFacet) one["facet"] = w.facet;
    if (i < p.excerpts.size()) one["lines"] = p.excerpts[i].lines, one["marked"] = p.excerpts[i].marked;
    all.push_back(std::move(one));
  }
  const Rest& rest = p.removal.rest;
  if (!p.verdict.rest.empty() && rest.facet != kNoFacet)
    all.push_back(
        {{"what", rest.never_cut ? "never cut, within the tool's reach" : "left, within the tool's reach"},
         {"amount", text("%.4f left", rest.left)},
         {"wrong", true},
         {"facet", rest.facet},
         {"place", place_json(rest.place)}});
  return all;
}

json figures_json(const CutViewParts& p) {
  const Removal& r = p.removal;
  return {{"gouge_mm", p.verdict.gouge},
          {"tolerance_mm", p.verdict.tolerance},
          {"median_mm", r.excess[3]},
          {"most_of_95_mm", r.excess[5]},
          {"removed_mm3", r.stock_volume - r.left_volume},
          {"seconds", r.seconds},
          {"rapid_seconds", r.rapid_seconds},
          {"air_seconds", r.air_seconds},
          {"moves", r.blocks},
          {"reach_mm", r.reach},
          {"resolution_mm", r.cell},
          {"area_mm2", r.area},
          {"touched_mm2", r.touched_area},
          {"rest_mm2", r.rest.area}};
}

}  // namespace

std::string cut_view(const CutViewParts& p) {
  if (p.probes.patches().mesh.facets.size() > kMostShownPatches) return {};
  PackedView view;
  const Poses poses(p.context.job, p.path);
  json head{{"format", 1},
            {"name", p.context.job.plan.name},
            {"source", p.context.source},
            {"machine", p.context.job.machine.model.name},
            {"stock", to_string(p.context.stock)},
            {"word", p.verdict.word()},
            {"failures", p.verdict.failures},
            {"rest", p.verdict.rest},
            {"begin_s", p.path.moves.front().start},
            {"end_s", p.path.moves.back().end},
            {"figures", figures_json(p)},
            {"places", places_json(p, poses)},
            {"tool", tool_json(p.context.job.plan.cutter)},
            {"diameter_mm", p.context.job.plan.cutter.diameter}};
  json scale = json::array();
  for (const ColourStop& stop : p.scale) scale.push_back({stop.left, html_colour(stop.colour)});
  head["scale"] = scale;
  head["never"] = html_colour(kUnreachedColour);
  add_mesh(view, p.probes.patches());
  head["unit_mm"] = add_amounts(view, p.removal);
  add_cuts(view, p.probes, p.path);
  add_poses(view, poses, p.path);
  add_machine(view, p.context.job);
  if (p.film) head["film"] = add_film(view, *p.film);
  std::string facts = head.dump(-1, ' ', true, json::error_handler_t::replace);
  return view.packed(facts.substr(1, facts.size() - 2));
}

}  // namespace tiltfeed::sim
