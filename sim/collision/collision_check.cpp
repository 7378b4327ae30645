#include "sim/collision/collision_check.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/basics/text.h"

namespace tiltfeed::sim {
namespace {

// A piece turns no axis further than this, degrees: sines of half of it still grow.
constexpr double kMostTurn = 180.0;
constexpr double kMostPieces = 10000.0;
// Of what a piece moves: bodies that are further apart than asked by this are taken for near while it can be
// halved.
constexpr double kPieceSlack = 0.25;
// Cells reach beyond the travels by this, mm: what is printed is rounded.
constexpr double kBeyond = 1.0;

bool endless(const RotaryAxis& axis) { return !(axis.max - axis.min <= 360.0); }

/// An axis that turns for ever is looked at from 0 to 360, a piece reaches beyond by what it turns.
JointBox root_of(const MachineModel& model) {
  JointBox box;
  const std::array<const LinearAxis*, 3> slides{&model.x, &model.y, &model.z};
  for (std::size_t i = 0; i < slides.size(); ++i)
    box.low[i] = slides[i]->min - kBeyond, box.high[i] = slides[i]->max + kBeyond;
  const std::array<const RotaryAxis*, 2> rotaries{&model.tilt, &model.rotary};
  for (std::size_t i = 0; i < rotaries.size(); ++i) {
    const bool round = endless(*rotaries[i]);
    box.low[kTiltAxis + i] = round ? -kMostTurn : rotaries[i]->min;
    box.high[kTiltAxis + i] = round ? 360.0 + kMostTurn : rotaries[i]->max;
  }
  return box;
}

double most_turn(const AxisWords& p, const AxisWords& q) {
  return std::max(std::abs(q[kTiltAxis] - p[kTiltAxis]), std::abs(q[kRotaryAxis] - p[kRotaryAxis]));
}

}  // namespace

/// Cells that were clear, from the piece before.
struct CollisionCheck::ClearBoxes {
  explicit ClearBoxes(std::size_t count) : pairs(count, JointBox::none()) {}

  std::vector<JointBox> pairs;
  JointBox all = JointBox::none();  ///< of all pairs that are looked at
};

bool CollisionPlace::worse_than(const CollisionPlace& other) const {
  return depth - apart > other.depth - other.apart;
}

void Collisions::add(Collisions next) {
  std::array<std::size_t, CollisionScene::kMostPairs> count{};
  for (const CollisionPlace& place : places) ++count[place.pair];
  for (CollisionPlace& place : next.places)
    if (++count[place.pair] <= kMostPlaces) places.push_back(std::move(place));
}

PairSet CollisionCheck::told(const Collisions& collisions) {
  std::array<std::size_t, CollisionScene::kMostPairs> count{};
  PairSet told = 0;
  for (const CollisionPlace& place : collisions.places)
    if (++count[place.pair] >= kMostPlaces) told |= PairSet{1} << place.pair;
  return told;
}

CollisionCheck::CollisionCheck(const config::Job& job, CollisionScene scene)
    : model_(job.machine.model),
      has_bodies_(!job.machine.solid.bodies.empty()),
      has_fixtures_(!job.fixtures.empty()),
      frames_(job.machine.model, job.setup),
      scene_(std::make_unique<CollisionScene>(std::move(scene))),
      feed_(std::make_unique<JointCells>(*scene_, root_of(model_), false)),
      rapid_(std::make_unique<JointCells>(*scene_, root_of(model_), true)) {}

Result<CollisionCheck> CollisionCheck::make(const pathgen::CheckedMesh& part, const config::Job& job) {
  auto scene = CollisionScene::make(part, job);
  if (!scene) return tl::unexpected(scene.error());
  return CollisionCheck(job, std::move(*scene));
}

std::string CollisionCheck::scope() const {
  if (idle()) return "collisions not checked: the machine profile has no bodies and the job no fixtures";
  std::string all =
      sim::text("no collision: %zu pairs of bodies keep their clearances", scene_->pairs().size());
  if (!has_bodies_) all += "; the machine itself is not checked, as its profile has no bodies";
  if (!has_fixtures_) all += "; the job has no fixtures";
  return all;
}

/// The move as straight pieces of joint space: under TCP in as many as keep the slides near their way.
void CollisionCheck::hold(const ProgramMove& move, PairSet told, ClearBoxes& clear, Collisions& found) const {
  const auto slides = [&](const Joints& words) { return move.tcp ? frames_.slide_words(words) : words; };
  const Joints from = slides(move.from), to = slides(move.to);
  double pieces = std::ceil(most_turn(words_of(from), words_of(to)) / kMostTurn);
  if (move.tcp) {
    const Pose begin = frames_.pose(move.from, true), end = frames_.pose(move.to, true);
    const double stray = frames_.stray({from, to, false, false, 0, 0}, begin, end, 0.0);
    pieces = std::max(pieces, std::ceil(std::sqrt(stray / kTcpStray)));
  }
  pieces = std::clamp(pieces, 1.0, kMostPieces);
  const Joints &p = move.from, &q = move.to;
  const auto at = [&](double share) {
    if (share == 0.0) return words_of(from);
    if (share == 1.0) return words_of(to);
    return words_of(slides({p.x + share * (q.x - p.x), p.y + share * (q.y - p.y), p.z + share * (q.z - p.z),
                            p.a + share * (q.a - p.a), p.c + share * (q.c - p.c)}));
  };
  AxisWords before = at(0.0);
  for (double i = 1.0; i <= pieces; ++i) {
    const AxisWords next = at(i / pieces);
    hold(JointPiece{before, next}, move, told, clear, found);
    before = next;
  }
}

void CollisionCheck::hold(const JointPiece& piece, const ProgramMove& move, PairSet told, ClearBoxes& clear,
                          Collisions& found) const {
  JointPiece turned = piece;  // whole turns back, where the axes stand alike
  const std::array<const RotaryAxis*, 2> rotaries{&model_.tilt, &model_.rotary};
  for (std::size_t i = 0; i < rotaries.size(); ++i) {
    if (!endless(*rotaries[i])) continue;
    const double turns = 360.0 * std::floor(piece.from[kTiltAxis + i] / 360.0);
    turned.from[kTiltAxis + i] -= turns, turned.to[kTiltAxis + i] -= turns;
  }
  const auto holds = [&](const JointBox& box) { return box.holds(turned.from) && box.holds(turned.to); };
  if (holds(clear.all)) return;
  JointCells& cells = move.rapid ? *rapid_ : *feed_;
  clear.all = JointBox::everything();
  for (std::size_t pair = 0; pair < scene_->pairs().size(); ++pair) {
    bool wanted = (told & PairSet{1} << pair) == 0;
    if (!wanted) continue;
    JointBox& box = clear.pairs[pair];
    if (!holds(box))
      cells.walk(pair, turned, box, [&](const JointPiece& rest) {
        JointPiece part = piece;
        part.begin = rest.begin, part.end = rest.end;
        wanted = wanted && !follow(pair, part, move, found);
      });
    clear.all.cut(box);
  }
}

/// (CO5) Along a piece, halved until it is clear or too short for what it may still hide. Whether it found
/// one.
bool CollisionCheck::follow(std::size_t index, const JointPiece& piece, const ProgramMove& move,
                            Collisions& found) const {
  const BodyPair& pair = scene_->pairs()[index];
  const double middle = 0.5 * (piece.begin + piece.end);
  const AxisWords words = piece.at(middle);
  AxisWords half{};
  for (std::size_t i = 0; i < half.size(); ++i)
    half[i] = 0.5 * (piece.end - piece.begin) * std::abs(piece.to[i] - piece.from[i]);
  const double motion = pair.motion(half);
  const bool last = motion <= 0.5 * kCollisionError;
  if (!scene_->nearer(pair, words, pair.asked(move.rapid) + motion, last ? 0.0 : kPieceSlack * motion))
    return false;
  if (last) {
    found.places.push_back(place(index, words, move));
    return true;
  }
  JointPiece first = piece, second = piece;
  first.end = second.begin = middle;
  return follow(index, first, move, found) || follow(index, second, move, found);
}

CollisionPlace CollisionCheck::place(std::size_t index, const AxisWords& words,
                                     const ProgramMove& move) const {
  const BodyPair& pair = scene_->pairs()[index];
  const BodyGroup &a = scene_->groups()[pair.a], &b = scene_->groups()[pair.b];
  CollisionPlace place{index, move.rapid, move.line, move.block, words, 0.0, 0.0, "", ""};
  const auto named = [](const BodyGroup& group, std::uint32_t facet) {
    const std::string& name = group.body_of(facet).name;
    return name.empty() ? group.word : group.word + " \"" + name + "\"";
  };
  const Placement pose = scene_->pose(pair, words);
  auto near = a.tree.nearest(b.tree, pose, pair.asked(move.rapid) + kCollisionError);
  place.apart = near ? near->distance : 0.0;
  if (!near) near = a.tree.nearest(b.tree, pose, kInfinity);  // one is in the other: whose surface is nearest
  place.first = named(a, near->a), place.second = named(b, near->b);
  return place;
}

void CollisionCheck::measure(Collisions& collisions) const {
  for (CollisionPlace& place : collisions.places)
    if (place.apart == 0.0) place.depth = depth(scene_->pairs()[place.pair], place.words);
}

/// How deep a corner of one is in the other, mm; 0: none is.
double CollisionCheck::depth(const BodyPair& pair, const AxisWords& words) const {
  const BodyTree &a = scene_->groups()[pair.a].tree, &b = scene_->groups()[pair.b].tree;
  const Placement pose = scene_->pose(pair, words), back = inverse(pose);
  double most = 0.0;
  const auto corners = [&](const BodyTree& of, const BodyTree& in, const Placement& as_seen) {
    for (const Vec3 v : of.vertices()) {
      const Vec3 p = as_seen(v);
      if (in.in_box(p) && in.inside(p)) most = std::max(most, in.distance(p));
    }
  };
  corners(a, b, back);
  corners(b, a, pose);
  return most;
}

bool CollisionCheck::one_in_other(const BodyPair& pair, const AxisWords& words) const {
  const BodyTree &a = scene_->groups()[pair.a].tree, &b = scene_->groups()[pair.b].tree;
  const Placement pose = scene_->pose(pair, words), back = inverse(pose);
  const auto any = [](const BodyTree& of, const BodyTree& in, const Placement& as_seen) {
    return std::any_of(of.shells().begin(), of.shells().end(), [&](Vec3 v) {
      const Vec3 p = as_seen(v);
      return in.in_box(p) && in.inside(p);
    });
  };
  return any(a, b, back) || any(b, a, pose);
}

Collisions CollisionCheck::hold(std::span<const ProgramMove> moves, PairSet told) const {
  Collisions found;
  ClearBoxes clear(scene_->pairs().size());
  bool rapid = false;
  for (const ProgramMove& move : moves) {
    if (move.rapid != rapid) clear = ClearBoxes(scene_->pairs().size());
    rapid = move.rapid;
    Collisions here;
    hold(move, told, clear, here);
    if (here.places.empty()) continue;
    found.add(std::move(here));
    told |= CollisionCheck::told(found);
  }
  return found;
}

Collisions CollisionCheck::look(const ProgramMove& move) const {
  ProgramMove still = move;
  still.from = still.to;
  Collisions found = hold(std::span(&still, 1), 0);
  const AxisWords words = words_of(move.tcp ? frames_.slide_words(move.to) : move.to);
  for (std::size_t pair = 0; pair < scene_->pairs().size(); ++pair) {
    const bool known = std::any_of(found.places.begin(), found.places.end(),
                                   [&](const CollisionPlace& place) { return place.pair == pair; });
    if (known || !one_in_other(scene_->pairs()[pair], words)) continue;
    found.places.push_back(place(pair, words, move));
  }
  return found;
}

std::string CollisionCheck::place_text(const CollisionPlace& p) const {
  std::string all = p.first + " and " + p.second;
  const double asked = scene_->pairs()[p.pair].asked(p.rapid);
  if (p.depth > 0.0)
    all += sim::text(", %.3f mm deep", p.depth);
  else
    all += p.apart > 0.0 ? sim::text(", %.3f mm apart, %.3f mm asked", p.apart, asked)
                         : ", their surfaces cross";
  all += sim::text(" in a %s move, block %llu, at X%.3f Y%.3f Z%.3f", p.rapid ? "rapid" : "feed",
                   static_cast<unsigned long long>(p.block), p.words[0], p.words[1], p.words[2]);
  const std::array<const RotaryAxis*, 2> rotaries{&model_.tilt, &model_.rotary};
  for (std::size_t i = 0; i < rotaries.size(); ++i)
    if (rotaries[i]->present) all += sim::text(" %c%.3f", rotaries[i]->letter, p.words[kTiltAxis + i]);
  return all;
}

std::string CollisionCheck::text(const Collisions& collisions, const std::string& name) const {
  const CollisionPlace *first = nullptr, *worst = nullptr;
  for (const CollisionPlace& place : collisions.places) {
    if (first == nullptr || place.block < first->block) first = &place;
    if (worst == nullptr || place.worse_than(*worst)) worst = &place;
  }
  std::string all = sim::text("%s:%u: collision: ", name.c_str(), first->line) + place_text(*first);
  if (worst != first) all += sim::text("; the worst, line %u: ", worst->line) + place_text(*worst);
  if (collisions.places.size() > 1)
    all += sim::text("; %zu places are known, a pair of bodies is not looked at after %zu of them",
                     collisions.places.size(), kMostPlaces);
  return all;
}

}  // namespace tiltfeed::sim
