#include "pathgen/suggest/suggest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "pathgen/axis/direction_grid.h"
#include "pathgen/indexed/set_cover.h"
#include "pathgen/suggest/features.h"
#include "pathgen/suggest/mounting.h"
#include "pathgen/suggest/placements.h"
#include "pathgen/suggest/plain_faces.h"
#include "pathgen/tool/contact_line.h"

namespace tiltfeed::pathgen {

namespace {

/// Places of the surface: for fitting features, for the search, and for what is said in the end.
constexpr std::size_t kFeaturePlaces = 3000, kSearchPlaces = 700, kFinalPlaces = 6000;
/// Placements of each mode that are searched on from, and that are told.
constexpr std::size_t kSearched = 2, kTold = 2;
/// (Q5) Steps of the search: of lengths as shares of the part's size, of angles in rad; halved so many times.
constexpr double kLengthStep = 0.12, kAngleStep = 0.2;
constexpr int kHalvings = 4, kMostTrials = 70;
/// Rounding a placement may cost this share of the surface.
constexpr double kWorthRounding = 0.003;
/// A fitted placement stands before a searched one that reaches no more than this share of the surface more.
constexpr double kWorthLeaving = 0.03;
/// So many times more must many directions reach to stand before one axis field.
constexpr double kWorthManyAxes = 1.1;
/// Frames nearer than this, as a share of the part's size and in rad, are one placement.
constexpr double kSame = 0.005;
/// Of the best proposal's share, what another one must reach to be told.
constexpr double kWorthTelling = 0.1;
/// Directions of the mode indexed.
constexpr std::uint32_t kMostIndexed = 6;

struct Tried {
  Placement placement;
  Mounted mounted;
  double share = 0.0;  ///< of the search's places
  bool moved = false;  ///< by the search
};

struct Sample {
  std::vector<ReachPlace> places;
  std::vector<double> weights;  ///< mm^2: (Q6)
  double whole = 0.0;           ///< of the weights
};

class Search {
 public:
  Search(const CheckedMesh& part, const SuggestOptions& options)
      : part_(part),
        scene_(part, options.tool),
        piece_(tool_pieces(options.tool).front()),
        tip_(reference_height(options.tool.cutter)),
        any_axis_(options.tool.cutter.type == CutterType::kBall ||
                  options.tool.cutter.type == CutterType::kTaperBall),
        size_(distance(part.bounds.min, part.bounds.max)),
        mounting_(options.machine, part.bounds, options.tool.cutter.length),
        few_{scene_.sample(kSearchPlaces), {}, 0.0},
        many_{scene_.sample(kFinalPlaces), {}, 0.0} {}

  Result<Suggestions> run(const Progress& progress) {
    const auto at = [&](const char* stage, double share) { return !progress || progress(stage, share); };
    if (!at("features", 0.0)) return cancelled();
    result_.features = find_features(part_.mesh, part_.bounds, scene_.sample(kFeaturePlaces));
    weigh(few_), weigh(many_);
    if (!at("placements", 0.2)) return cancelled();
    for (const Placement& placement : first_placements(result_.features, part_.bounds, few_.places))
      try_out(placement);
    add_directions();
    double done = 0.3;
    for (const AxisMode mode : {AxisMode::kFixed, AxisMode::kPoint, AxisMode::kLine, AxisMode::kCircle}) {
      if (!at("search", done)) return cancelled();
      done += 0.13;
      search(mode);
    }
    if (!at("ranking", 0.85)) return cancelled();
    for (const AxisMode mode : {AxisMode::kFixed, AxisMode::kPoint, AxisMode::kLine, AxisMode::kCircle})
      tell(mode);
    const MachineModel* machine = mounting_.machine();
    const bool turns_every_way = machine == nullptr || (machine->tilt.present && machine->rotary.present);
    if (any_axis_ && turns_every_way) tell_free();
    leave_out_the_least();
    rank();
    result_.tried = tried_, result_.places = many_.places.size();
    if (result_.proposals.empty())
      return fail(Code::kUnreachable,
                  "no placement of the tool axis reaches anything of the part: check the cutter's size and "
                  "the part's "
                  "unit");
    return std::move(result_);
  }

 private:
  static ReachQuestion question(const AxisFrame& axis) {
    ReachQuestion q;
    q.axis = axis;
    q.clearance = kProposedClearance;
    return q;
  }

  /// What rays reach with this frame, as poses.
  std::vector<CutPose> poses(const AxisFrame& axis, const Sample& sample,
                             std::vector<ReachPlace>* cut = nullptr) {
    const ReachQuestion q = question(axis);
    const std::vector<ReachPlace>& places = sample.places;
    const ReachMap map = scene_.ask(q, places, Rays::kRim);
    const Deformation field(axis, 1.0);
    const DrawnBack drawn_back(q, part_.bounds);
    std::vector<CutPose> found;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (map.places[i] != Reach::kCut) continue;
      const AxisLine line = contact_line(piece_, field, places[i].place, places[i].normal);
      found.push_back(
          {{line.base - line.axis * tip_, line.axis}, sample.weights[i], drawn_back(line.base, line.axis)});
      if (cut != nullptr) cut->push_back(places[i]);
    }
    return found;
  }

  Mounted mount(const AxisFrame& axis, std::span<const CutPose> cut) const {
    const bool has_axis =
        axis.mode == AxisMode::kLine || axis.mode == AxisMode::kCircle || axis.mode == AxisMode::kFixed;
    return mounting_.best(cut, has_axis ? std::optional(axis_of(axis)) : std::nullopt,
                          axis.mode == AxisMode::kFixed ? std::nullopt : std::optional(near(axis)));
  }
  /// Of the feature, what lies next to the part's middle: that goes on the table's axis, unless it is far
  /// off.
  Point<Part> near(const AxisFrame& axis) const {
    const Point<Part> middle = lerp(part_.bounds.min, part_.bounds.max, 0.5);
    Point<Part> at = axis.origin;
    if (axis.mode == AxisMode::kLine) at = at + axis.t * dot(middle - at, axis.t);
    return distance(at, middle) < 0.3 * size_ ? at : middle;
  }

  Tried asked(const Placement& placement) {
    ++tried_;
    const std::vector<CutPose> cut = poses(placement.axis, few_);
    Tried tried{placement, mount(placement.axis, cut), 0.0, false};
    tried.share = tried.mounted.area / few_.whole;
    return tried;
  }
  void weigh(Sample& sample) const {
    sample.weights = weights_of(part_.mesh, sample.places, result_.features, size_);
    sample.whole = std::accumulate(sample.weights.begin(), sample.weights.end(), 0.0);
  }
  double shaped(const ReachMap& map, const Sample& sample) const {
    double cut = 0.0;
    for (std::size_t i = 0; i < map.places.size(); ++i)
      if (map.places[i] == Reach::kCut) cut += sample.weights[i];
    return cut / sample.whole;
  }
  void try_out(const Placement& placement) {
    Tried tried = asked(placement);
    if (tried.share > 0.0) tried_out_.push_back(std::move(tried));
  }

  /// Fixed axes of an even grid.
  void add_directions() {
    const DirectionGrid grid(1);
    for (const Vec3 d : grid.directions())
      try_out({frame_about(AxisMode::kFixed, Sense::kOutward, {}, d, 0.0), "all directions", 0.0});
  }

  /// The best of a mode first.
  std::vector<Tried> best_of(AxisMode mode) const {
    std::vector<Tried> of;
    for (const Tried& t : tried_out_)
      if (t.placement.axis.mode == mode) of.push_back(t);
    std::stable_sort(of.begin(), of.end(), [](const Tried& a, const Tried& b) { return a.share > b.share; });
    return of;
  }

  void search(AxisMode mode) {
    std::vector<Tried> starts = best_of(mode);
    if (starts.size() > kSearched) starts.resize(kSearched);
    for (const Tried& start : starts) {
      Tried best = climbed(start);
      if (best.moved) tried_out_.push_back(tidied(std::move(best)));
    }
  }

  /// (Q5) Steps along each freedom of the frame, as long as one gains.
  Tried climbed(Tried best) {
    int trials = 0;
    double length_step = kLengthStep * size_, angle_step = kAngleStep;
    for (int k = 0; k < kHalvings && trials < kMostTrials; ++k, length_step /= 2.0, angle_step /= 2.0) {
      bool gained = true;
      while (gained && trials < kMostTrials) {
        gained = false;
        for (const AxisFrame& frame : neighbours(best.placement.axis, length_step, angle_step)) {
          if (++trials > kMostTrials) break;
          Tried tried = asked({frame, "search", 0.0});
          if (tried.share > best.share + 1e-9) best = std::move(tried), best.moved = gained = true;
        }
      }
    }
    return best;
  }

  static std::vector<AxisFrame> neighbours(const AxisFrame& frame, double length_step, double angle_step) {
    std::vector<AxisFrame> near;
    const Vec3 axis = axis_of(frame);
    const Vec3 pick = std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 u = normalized(cross(axis, pick)), v = cross(axis, u);
    const auto add = [&](Vec3 shift, Vec3 lean, double radius) {
      near.push_back(
          frame_about(frame.mode, frame.sense, frame.origin + shift, normalized(axis + lean), radius));
    };
    const double r = frame.circle_radius;
    for (const double s : {1.0, -1.0}) {
      if (frame.mode != AxisMode::kFixed)
        for (const Vec3 way : {u, v}) add(way * (s * length_step), {}, r);
      if (frame.mode == AxisMode::kPoint || frame.mode == AxisMode::kCircle)
        add(axis * (s * length_step), {}, r);
      if (frame.mode != AxisMode::kPoint)
        for (const Vec3 way : {u, v}) add({}, way * (s * std::tan(angle_step)), r);
      if (frame.mode == AxisMode::kCircle && r + s * length_step > 0.02 * length_step)
        add({}, {}, r + s * length_step);
    }
    return near;
  }

  /// In round numbers, as far as that costs nothing.
  Tried tidied(Tried found) {
    const double decade = std::pow(10.0, std::floor(std::log10(size_ / 10.0)));
    for (const double step : {decade, decade / 2.0, decade / 10.0}) {
      Tried round = asked({rounded(found.placement.axis, step, 0.06), "search", 0.0});
      if (round.share >= found.share - kWorthRounding) return round.moved = true, round;
    }
    return found;
  }

  /// The best of a mode, asked of all places.
  void tell(AxisMode mode) {
    std::vector<Tried> of = best_of(mode);
    std::stable_sort(of.begin(), of.end(), [](const Tried& a, const Tried& b) {
      const auto worth = [](const Tried& t) {
        return t.share + (t.placement.source == "fitted" ? kWorthLeaving : 0.0);
      };
      return worth(a) > worth(b);
    });
    std::size_t told = 0;
    bool fitted = false;
    for (std::size_t i = 0; i < of.size(); ++i) {
      // The best, and besides the best that the surface itself says.
      const bool is_fitted = of[i].placement.source == "fitted";
      if (told >= kTold && (!is_fitted || fitted)) continue;
      std::vector<ReachPlace> cut;
      const auto same = [&](const Proposal& p) { return one_placement(p.axis, of[i].placement.axis); };
      if (std::any_of(result_.proposals.begin(), result_.proposals.end(), same)) continue;
      const std::vector<CutPose> there = poses(of[i].placement.axis, many_, &cut);
      if (there.empty()) continue;
      Proposal proposal;
      proposal.axis = well_turned(of[i].placement.axis, cut);
      proposal.source = of[i].placement.source, proposal.rms = of[i].placement.rms;
      proposal.fixture_deg = of[i].mounted.fixture_deg;
      add(std::move(proposal), mounting_.raised(of[i].mounted.setup, there));
      ++told, fitted = fitted || is_fitted;
    }
  }

  bool one_placement(const AxisFrame& a, const AxisFrame& b) const {
    if (a.mode != b.mode || a.sense != b.sense) return false;
    const Vec3 axis = axis_of(a), off = b.origin - a.origin;
    const double near = kSame * size_;
    if (a.mode != AxisMode::kPoint) {
      const double turn = angle_between(axis, axis_of(b));
      if ((a.mode == AxisMode::kFixed ? turn : std::min(turn, kPi - turn)) > kSame) return false;
    }
    if (a.mode == AxisMode::kFixed) return true;
    if (a.mode == AxisMode::kLine) return length(cross(off, axis)) < near;
    return length(off) < near && std::abs(a.circle_radius - b.circle_radius) < near;
  }

  void add(Proposal proposal, const Setup& setup) {
    const std::optional<MachineReach> reach = mounting_.reach(setup);
    ReachQuestion q = question(proposal.axis);
    q.directions = proposal.directions;
    q.machine = reach ? &*reach : nullptr;
    proposal.setup = setup;
    proposal.reach = scene_.ask(q, many_.places, Rays::kRim);
    proposal.shaped = shaped(proposal.reach, many_);
    if (proposal.share() > 0.0) result_.proposals.push_back(std::move(proposal));
  }

  /// The free axis, and the fewest fixed directions, both turned on the table as the free one reaches most.
  void tell_free() {
    ReachQuestion q = question({.mode = AxisMode::kFree, .origin = {}});
    Vec3 best_way;
    double most = -1.0;
    const MachineModel* machine = mounting_.machine();
    for (const Vec3 way : mounting_.quarters()) {
      const Setup setup = mounting_.setup(way, std::nullopt);
      const std::optional<MachineReach> reach = mounting_.reach(setup);
      q.machine = reach ? &*reach : nullptr;
      const double share = shaped(scene_.ask(q, few_.places, Rays::kAxis), few_);
      ++tried_;
      if (share > most + (most < 0.0 ? 0.0 : kWorthRounding)) most = share, best_way = way;
      if (machine == nullptr) break;
    }
    Proposal free;
    free.axis.mode = AxisMode::kFree, free.source = "all directions", free.fixture_deg = best_way;
    Setup setup = mounting_.setup(best_way, std::nullopt);
    Proposal indexed = free;
    indexed.axis.mode = AxisMode::kIndexed;
    std::vector<CutPose> there;
    indexed.directions = fixed_directions(setup, there);
    setup = mounting_.raised(setup, there);
    add(std::move(free), setup);
    if (!indexed.directions.empty()) add(std::move(indexed), setup);
  }

  /// Few directions that together reach most; `there`: poses that they cut.
  std::vector<Vec3> fixed_directions(const Setup& setup, std::vector<CutPose>& there) {
    const std::optional<MachineReach> reach = mounting_.reach(setup);
    ReachQuestion q = question({.mode = AxisMode::kIndexed, .origin = {}});
    q.machine = reach ? &*reach : nullptr;
    std::vector<Vec3> directions{{0, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, -1}};
    const DirectionGrid grid(2);
    for (const Vec3 d : grid.directions()) directions.push_back(d);
    std::vector<std::vector<std::uint8_t>> sets;
    for (const Vec3 d : directions) {
      q.directions = {d};
      const ReachMap map = scene_.ask(q, few_.places, Rays::kRim);
      std::vector<std::uint8_t>& set = sets.emplace_back();
      for (const Reach r : map.places) set.push_back(r == Reach::kCut ? 1 : 0);
    }
    const DrawnBack drawn_back(q, part_.bounds);
    const SetCover cover = cover_by_few(sets, 0.99, kMostIndexed, 0.01);
    std::vector<Vec3> chosen;
    for (const std::uint32_t s : cover.chosen) {
      chosen.push_back(directions[s]);
      for (std::size_t i = 0; i < few_.places.size(); ++i) {
        if (sets[s][i] == 0) continue;
        const Point<Part> at =
            contact_reference(piece_, chosen.back(), few_.places[i].place, few_.places[i].normal);
        there.push_back(
            {{at - chosen.back() * tip_, chosen.back()}, few_.weights[i], drawn_back(at, chosen.back())});
      }
    }
    return chosen;
  }

  void leave_out_the_least() {
    double most = 0.0;
    for (const Proposal& p : result_.proposals) most = std::max(most, p.share());
    std::erase_if(result_.proposals, [&](const Proposal& p) { return p.share() < kWorthTelling * most; });
  }

  /// (Q6) By what they reach; a fitted one before what reaches hardly more, and one axis field before many
  /// directions that do.
  void rank() {
    const auto worth = [](const Proposal& p) {
      const bool field = p.axis.mode != AxisMode::kFree && p.axis.mode != AxisMode::kIndexed;
      return p.shaped * (field ? kWorthManyAxes : 1.0) + (p.source == "fitted" ? kWorthLeaving : 0.0);
    };
    std::stable_sort(result_.proposals.begin(), result_.proposals.end(),
                     [&](const Proposal& a, const Proposal& b) { return worth(a) > worth(b); });
  }

  const CheckedMesh& part_;
  const ReachScene scene_;
  const ToolPiece piece_;
  const double tip_;
  const bool any_axis_;
  const double size_;
  const Mounting mounting_;
  Sample few_, many_;
  std::vector<Tried> tried_out_;
  std::size_t tried_ = 0;
  Suggestions result_;
};

}  // namespace

Result<Suggestions> suggest(const CheckedMesh& part, const SuggestOptions& options,
                            const Progress& progress) {
  return Search(part, options).run(progress);
}

}  // namespace tiltfeed::pathgen
