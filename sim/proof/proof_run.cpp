#include "sim/proof/proof_run.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// Moves that are held against the same facets: as many, and as long together as so many roundings, mm.
constexpr std::size_t kMostTogether = 64;
constexpr double kTogether = 1.5, kShortest = 0.5, kLongest = 4.0;
// So many facets for moves that may still be divided are looked for again, for each half by itself.
constexpr std::size_t kManyFacets = 200;
// What is deeper than told, by this share of the tolerance, is looked at more closely.
constexpr double kLooseError = 0.05;
// Of so many moves that cut too deep the depth is measured.
constexpr int kMostTold = 32;
// A move is halved at most this often.
constexpr int kMostHalvings = 40;
// What is far from the part is looked at with this much room, mm, and twice as much if it is farther.
constexpr double kFirstRoom = 0.25, kMostRoom = 64.0;
// Room is asked for after so many looks at which nothing was near.
constexpr int kPatience = 4;
// Above this the surface winds round the point: inside.
constexpr double kInside = 0.5;

Point<Part> along(const Pose& pose, double height) { return pose.tip + pose.axis * height; }

}  // namespace

void Proof::add(const Proof& next) {
  moves += next.moves;
  gouge = std::max(gouge, next.gouge);
  if (next.deepest && (!deepest || next.deepest->depth > deepest->depth)) deepest = next.deepest;
}

namespace {

/// The hull of where a core's axis is at both ends of a node: does a box stay further off than `reach`?
class Reach {
 public:
  Reach(const std::array<Vec3, 4>& ends, double reach)
      : ends_(ends), reach2_(reach * reach), from_((ends[0] + ends[2]) * 0.5) {
    along_ = (ends[1] + ends[3]) * 0.5 - from_;
    whole_ = squared_length(along_);
    low_ = high_ = ends[0];
    for (const Vec3 p : ends) low_ = lower(low_, p), high_ = upper(high_, p);
  }
  bool misses(Vec3 low, Vec3 high) const {
    const Vec3 gap{std::max({low.x - high_.x, low_.x - high.x, 0.0}),
                   std::max({low.y - high_.y, low_.y - high.y, 0.0}),
                   std::max({low.z - high_.z, low_.z - high.z, 0.0})};
    if (squared_length(gap) >= reach2_) return true;
    // Along the line from the axis half way to the box's middle.
    const Vec3 middle = (low + high) * 0.5, half = (high - low) * 0.5, m = middle - from_;
    const double share = whole_ > 0.0 ? std::clamp(dot(m, along_) / whole_, 0.0, 1.0) : 0.0;
    const Vec3 u = m - along_ * share;
    double most = dot(u, ends_[0]);
    for (std::size_t i = 1; i < ends_.size(); ++i) most = std::max(most, dot(u, ends_[i]));
    const double wide = std::abs(u.x) * half.x + std::abs(u.y) * half.y + std::abs(u.z) * half.z;
    const double apart = dot(u, middle) - wide - most;
    return apart > 0.0 && apart * apart >= reach2_ * squared_length(u);
  }

 private:
  const std::array<Vec3, 4>& ends_;
  double reach2_, whole_ = 0.0;
  Vec3 from_, along_, low_, high_;
};

}  // namespace

Prover::Run::Run(const Prover& prover, std::span<const ProgramMove> moves, double known)
    : prover_(prover), moves_(moves) {
  proof_.gouge = known;
  ways_.reserve(moves.size());
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const ProgramMove& move = moves[i];
    const bool joined = i > 0 && moves[i - 1].to == move.from && moves[i - 1].tcp == move.tcp;
    ways_.push_back({joined ? ways_.back().to : prover.frames_.pose(move.from, move.tcp),
                     prover.frames_.pose(move.to, move.tcp)});
    if (MoveFrames::turns(move)) ways_.back().middle = prover.frames_.pose(move, 0.5);
  }
}

Prover::Run::Node Prover::Run::with_ends(Node node) const {
  node.ends = {from_origin(along(node.from, core_->low)), from_origin(along(node.from, core_->high)),
               from_origin(along(node.to, core_->low)), from_origin(along(node.to, core_->high))};
  return node;
}

Vec3 Prover::Run::furthest(const Node& node, Vec3 u) const {
  if (core_->wide == 0.0) {
    const Vec3* best = &node.ends[0];
    double most = dot(*best, u);
    for (std::size_t i = 1; i < node.ends.size(); ++i)
      if (const double value = dot(node.ends[i], u); value > most) most = value, best = &node.ends[i];
    return *best;
  }
  const Vec3 p = from_origin(node.from.tip) + core_->furthest(node.from.axis, u);
  const Vec3 q = from_origin(node.to.tip) + core_->furthest(node.to.axis, u);
  return dot(p, u) >= dot(q, u) ? p : q;
}

/// How long the way of the core's ends is.
double Prover::Run::length_of(const Node& node) const {
  return std::max(distance(along(node.from, core_->low), along(node.to, core_->low)),
                  distance(along(node.from, core_->high), along(node.to, core_->high)));
}

/// By how much the hull of both ends may be nearer to the part than the tool is.
double Prover::Run::slack(const Node& node) const {
  const Vec3 l0 = from_origin(along(node.from, core_->low)), l1 = from_origin(along(node.to, core_->low));
  const Vec3 u0 = from_origin(along(node.from, core_->high)), u1 = from_origin(along(node.to, core_->high));
  const Vec3 normal = cross(u1 - l0, u0 - l1);
  const double size = length(normal);
  const double twist = size > 0.0 ? std::abs(dot((l0 + u1 - l1 - u0) * 0.5, normal)) / size : 0.0;
  const double turn = length(node.to.axis - node.from.axis);
  return 2.0 * node.stray + twist + core_->wide * turn * turn;
}

Prover::Run::Node Prover::Run::node(std::size_t first, std::size_t last) const {
  Node whole = with_ends({first, last, 0.0, 1.0, ways_[first].from, ways_[last].to, 0.0, 0, {}});
  const Point<Part> l0 = along(whole.from, core_->low), u0 = along(whole.from, core_->high);
  const Vec3 low = along(whole.to, core_->low) - l0, high = along(whole.to, core_->high) - u0,
             turn = whole.to.axis - whole.from.axis;
  const double square = squared_length(low);
  for (std::size_t i = first; i <= last; ++i) {
    double off = 0.0;
    if (i < last) {
      const Pose& pose = ways_[i].to;
      const Vec3 l = along(pose, core_->low) - l0, u = along(pose, core_->high) - u0;
      const double share = square > 0.0 ? std::clamp(dot(l, low) / square, 0.0, 1.0) : 0.0;
      off = std::max(length(l - low * share), length(u - high * share));
      if (core_->wide > 0.0) off += core_->wide * length(pose.axis - whole.from.axis - turn * share);
    }
    // The straight ways to this end and from it are no further off than their ends are.
    whole.stray = std::max(whole.stray, off + ways_[i].stray);
    if (i < last) whole.stray = std::max(whole.stray, off + ways_[i + 1].stray);
  }
  return whole;
}

Prover::Run::Node Prover::Run::part_of(const Node& whole, double begin, double end) const {
  const ProgramMove& move = moves_[whole.first];
  const double share = end - begin;
  return with_ends({whole.first,
                    whole.first,
                    begin,
                    end,
                    begin == whole.begin ? whole.from : prover_.frames_.pose(move, begin),
                    end == whole.end ? whole.to : prover_.frames_.pose(move, end),
                    ways_[whole.first].stray * share * share,
                    whole.halvings + 1,
                    {}});
}

bool Prover::Run::halves(const Node& whole, Node& left, Node& right) const {
  if (whole.first < whole.last) {
    const std::size_t middle = (whole.first + whole.last) / 2;
    left = node(whole.first, middle), right = node(middle + 1, whole.last);
    return true;
  }
  if (whole.halvings >= kMostHalvings) return false;
  const double middle = 0.5 * (whole.begin + whole.end);
  left = part_of(whole, whole.begin, middle), right = part_of(whole, middle, whole.end);
  return true;
}

/// The tool has not come further from where it was than it had room.
bool Prover::Run::far(const Node& node) const {
  if (room_ <= 0.0) return false;
  const auto moved = [&](const Pose& pose) {
    return distance(along(pose, core_->low), along(far_from_, core_->low)) +
           (core_->high - core_->low + core_->wide) * length(pose.axis - far_from_.axis);
  };
  return std::max(moved(node.from), moved(node.to)) + node.stray <= room_;
}

/// The facets that may be too near to the core somewhere, or within room of it, onto the stack.
void Prover::Run::gather(const Node& node) {
  const double need = enough(node) + ask_room_;
  const Reach reach(node.ends, need + core_->wide);
  const double nearest = dot(along_, furthest(node, -along_));
  const std::size_t most = facets_.size() + kManyFacets;
  const bool divides = length_of(node) > kShortest;
  const auto apart = [&](Vec3 low, Vec3 high) {
    const Vec3 far{along_.x >= 0.0 ? high.x : low.x, along_.y >= 0.0 ? high.y : low.y,
                   along_.z >= 0.0 ? high.z : low.z};
    return nearest - dot(along_, far) >= need || (divides && facets_.size() > most) ||
           reach.misses(low, high);
  };
  double least = kInfinity;
  const auto take = [&](const Triangle& t) { facets_.push_back(&t); };
  if (core_->wide == 0.0)
    return prover_.surface_.search(
        least, kNoFacet, [&](Vec3 low, Vec3 high) { return apart(low, high) ? kInfinity : 0.0; }, take);
  // A wide core is well inside the cylinder that was asked: the piece itself, half way, tells more.
  const Pose pose{lerp(node.from.tip, node.to.tip, 0.5), normalized(node.from.axis + node.to.axis)};
  const Standing standing(*core_->solid, pose);
  const double off = 0.5 * length_of(node) + core_->reach * length(node.to.axis - node.from.axis);
  const double clear = need - core_->rounding + off + kGapError;
  const auto bound = [&](Vec3 low, Vec3 high) {
    return apart(low, high) || standing.distance_bound(low, high) >= clear ? kInfinity : 0.0;
  };
  prover_.surface_.search(least, kNoFacet, bound, take);
}

void Prover::Run::hold(const Node& node) {
  if (told_ >= kMostTold || far(node)) return;
  const std::size_t begin = facets_.size();
  gather(node);
  const std::size_t count = facets_.size() - begin;
  if (count == 0) {
    far_from_ = node.to, room_ = ask_room_ - node.stray;
    ask_room_ = ++clear_looks_ > kPatience ? std::clamp(2.0 * ask_room_, kFirstRoom, kMostRoom) : 0.0;
    return;
  }
  if (ask_room_ > 0.0) clear_looks_ = 0;
  ask_room_ = 0.25 * ask_room_ < kFirstRoom ? 0.0 : 0.25 * ask_room_;
  Node left, right;
  if (count > kManyFacets && length_of(node) > kShortest && halves(node, left, right)) {
    facets_.resize(begin);
    hold(left);
    hold(right);
    return;
  }
  hold(node, begin, facets_.size());
  facets_.resize(begin);
}

void Prover::Run::hold(const Node& node, std::size_t begin, std::size_t end) {
  if (node.first == node.last && told_ > 0 && told_move_ == node.first) return;
  double nearest = dot(along_, furthest(node, -along_)), narrowest = kInfinity;
  const Triangle* worst = nullptr;
  Vec3 before = along_;
  // Of a node that is divided anyway it need not be known how near the facets are that are too near.
  const bool divides = node.first < node.last ||
                       (node.halvings < kMostHalvings && slack(node) > kLooseError * prover_.tolerance_);
  for (std::size_t i = begin; i < end; ++i) {
    double width = 0.0;
    const Triangle* const facet = facets_[i];
    if (along_ != before) before = along_, nearest = dot(along_, furthest(node, -along_));
    if (clear(node, nearest, *facet, divides, width)) continue;
    if (width < narrowest) narrowest = width, worst = facet;
    facets_.push_back(facet);
  }
  const auto hold_halves = [&] {
    Node left, right;
    if (!halves(node, left, right)) return false;
    const std::size_t left_end = facets_.size();
    hold(left, end, left_end);
    hold(right, end, left_end);
    return true;
  };
  if (worst != nullptr && divides) {
    hold_halves();
  } else if (worst != nullptr) {
    const double depth = core_->rounding - std::max(0.0, narrowest - node.stray) / core_->sharpness;
    const double fine = (depth > prover_.tolerance_ ? kProofError : kLooseError) * prover_.tolerance_;
    const bool tells = depth > std::min(level_, core_->rounding - 2.0 * kPierced);
    bool whole = slack(node) <= fine;
    double share = 0.5 * (node.begin + node.end);
    if (whole && tells) {
      double width = kInfinity;
      const double enough = narrowest + fine * core_->sharpness;
      share = nearest_share(node, *worst, enough, fine, width);
      whole = width <= enough;
    }
    if ((whole || !hold_halves()) && tells) tell(node, share, depth, *worst);
  }
  facets_.resize(end);
}

Proof Prover::Run::hold() {
  proof_.moves = static_cast<std::uint64_t>(
      std::count_if(moves_.begin(), moves_.end(), [](const ProgramMove& move) { return !move.goes_on; }));
  for (const ToolCore& core : prover_.cores_) {
    core_ = &core;
    level_ = proof_.gouge, room_ = -1.0, ask_room_ = 0.0, clear_looks_ = told_ = 0, along_ = {0, 0, 1};
    for (std::size_t i = 0; i < moves_.size(); ++i)
      ways_[i].stray =
          prover_.frames_.stray(moves_[i], ways_[i].from, ways_[i].middle, ways_[i].to, core.reach);
    const double most = std::clamp(kTogether * std::max(core.rounding, core.wide), kShortest, kLongest);
    for (std::size_t first = 0; first < moves_.size();) {
      std::size_t last = first;
      while (last + 1 < moves_.size() && last + 1 - first < kMostTogether &&
             ways_[last + 1].from.tip == ways_[last].to.tip &&
             distance(along(ways_[first].from, core.low), along(ways_[last + 1].to, core.low)) <= most &&
             distance(along(ways_[first].from, core.high), along(ways_[last + 1].to, core.high)) <= most)
        ++last;
      hold(node(first, last));
      first = last + 1;
    }
    proof_.gouge = std::max(proof_.gouge, level_);
  }
  return proof_;
}

Prover::Prover(const pathgen::CheckedMesh& part, const config::Job& job)
    : part_(part),
      tolerance_(job.plan.tolerance),
      surface_(part.mesh),
      solid_(job.plan.cutter, {job.plan.allowance, job.plan.radial_stock, job.plan.axial_stock}),
      cores_(tool_cores(solid_, job.plan.tolerance * (1.0 + 2.0 * kProofError))),
      frames_(job.machine.model, job.setup) {}

Proof Prover::hold(std::span<const ProgramMove> moves, double known) const {
  return Run(*this, moves, known).hold();
}

bool Prover::inside(const Pose& pose) const {
  const pathgen::Box& box = part_.bounds;
  const Point<Part> p = pose.tip;
  if (part_.sides != pathgen::Sides::kOutward || p.x < box.min.x || p.x > box.max.x || p.y < box.min.y ||
      p.y > box.max.y || p.z < box.min.z || p.z > box.max.z)
    return false;
  return surface_.winding_number(p) > kInside;
}

}  // namespace tiltfeed::sim
