// The check of collisions against plain distances of convex bodies at 1,000 places of every block of a
// program: an own chain of links, bodies as their formulas, no tree. Distances are libccd's, on
// which FCL stands, so that nothing of the product judges itself. A place is passed over where two bodies
// cannot have come nearer than at another place of the block, or than 1 mm over what is asked: by the
// distance that was measured last, less all that they moved since, or by the balls that hold them. Run by
// collision_places.py.
//
// collision_places JOB PROGRAM

#include <fcl/narrowphase/detail/convexity_based_algorithm/gjk_libccd.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "config/job.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "sim/basics/text.h"
#include "sim/collision/collision_check.h"
#include "sim/control/control_reader.h"

namespace tiltfeed::sim {
namespace {

constexpr int kPlaces = 1000;
constexpr double kFar = 50.0;   // mm: nobody asks for so much
constexpr double kSure = 1e-6;  // mm, to which a distance is found
// Further apart than asked by this much and what they move to the next places nobody has to know how far.
constexpr double kNear = 1.0;  // mm
constexpr unsigned kMostLooks = 1000;
constexpr std::size_t kMostTold = 1000000;  // bytes of the places that are too near
// What a "hit" may be further apart than is asked, mm: the check's own error, two meshes of round bodies,
// TCP.
constexpr double kTold = kCollisionError + 0.02 + 0.01;

struct Frame {
  Rotation turn;
  Vec3 shift;

  Frame then(const Frame& inner) const { return {turn * inner.turn, turn * inner.shift + shift}; }
};

/// A convex body at home: the point that lies furthest along a direction.
struct Convex {
  std::function<Vec3(Vec3)> furthest;
  Vec3 centre;
  double radius = 0.0;  ///< of a ball about `centre` that holds it
};

struct Group {
  std::string word;  ///< as the check's messages begin
  int link = 0;
  double clearance = 0.0;
  bool machine = false, tool = false, part = false;
  std::vector<Convex> bodies;
};

/// The links from the work to the tool, where each is relative to the bed.
class Chain {
 public:
  explicit Chain(const config::Job& job) : job_(job) {
    const MachineModel& m = job.machine.model;
    const auto& solid = job.machine.solid;
    under_tilt_ = m.structure == Structure::kTableTable && m.tilt.present;
    over_rotary_ = m.structure == Structure::kHeadHead && m.rotary.present;
    under_rotary_ = !over_rotary_ && m.rotary.present;
    over_tilt_ = m.structure != Structure::kTableTable && m.tilt.present;
    const int rotaries = (under_rotary_ ? 1 : 0) + (under_tilt_ ? 1 : 0);
    bed_ = rotaries + static_cast<int>(solid.work_slides.size());
    fork_ = bed_ + static_cast<int>(solid.tool_slides.size());
    head_ = fork_ + (over_rotary_ ? 1 : 0) + (over_tilt_ ? 1 : 0);
  }
  int links() const { return head_ + 1; }
  int link(config::BodyLink body) const {
    const auto& solid = job_.machine.solid;
    const auto slide = [&](int axis) {
      for (std::size_t i = 0; i < solid.work_slides.size(); ++i)
        if (solid.work_slides[i] == axis) return bed_ - 1 - static_cast<int>(i);
      for (std::size_t i = 0; i < solid.tool_slides.size(); ++i)
        if (solid.tool_slides[i] == axis) return bed_ + 1 + static_cast<int>(i);
      return bed_;
    };
    using config::BodyLink;
    switch (body) {
      case BodyLink::kBed:
        return bed_;
      case BodyLink::kXSlide:
        return slide(0);
      case BodyLink::kYSlide:
        return slide(1);
      case BodyLink::kZSlide:
        return slide(2);
      case BodyLink::kTable:
        return 0;
      case BodyLink::kCradle:
        return 1;
      case BodyLink::kFork:
        return fork_ + 1;
      case BodyLink::kHead:
      case BodyLink::kNose:
        break;
    }
    return head_;
  }
  /// At words of slides and rotaries.
  std::vector<Frame> frames(const Joints& words) const {
    const MachineModel& m = job_.machine.model;
    const Vec3 centre = from_origin(m.table_centre);
    const Vec3 slides =
        Vec3{words.x, words.y, words.z} + centre + job_.setup.part_zero + m.spindle * job_.setup.tool_length;
    const auto along = [&](int axis, double sign) -> Frame {
      return {{}, Vec3{axis == 0 ? slides.x : 0, axis == 1 ? slides.y : 0, axis == 2 ? slides.z : 0} * sign};
    };
    const auto about = [](const RotaryAxis& axis, double word, Vec3 point) -> Frame {
      const double angle = axis.sign * Angle::from_degrees(word - axis.zero).radians();
      const Rotation turn = rotation_about(axis.direction, angle);
      return {turn, point - turn * point};
    };
    std::vector<Frame> all(static_cast<std::size_t>(links()));
    const auto at = [&](int link) -> Frame& { return all[static_cast<std::size_t>(link)]; };
    int link = bed_;
    for (const int axis : job_.machine.solid.work_slides)
      at(link - 1) = at(link).then(along(axis, -1)), --link;
    if (under_tilt_) at(link - 1) = at(link).then(about(m.tilt, words.a, centre + m.rotary_to_tilt)), --link;
    if (under_rotary_) at(link - 1) = at(link).then(about(m.rotary, words.c, centre)), --link;
    link = bed_;
    for (const int axis : job_.machine.solid.tool_slides)
      at(link + 1) = at(link).then(along(axis, 1)), ++link;
    const Vec3 pivot = -m.pivot_to_gauge;
    if (over_rotary_)
      at(link + 1) = at(link).then(about(m.rotary, words.c, pivot - m.rotary_to_tilt)), ++link;
    if (over_tilt_) at(link + 1) = at(link).then(about(m.tilt, words.a, pivot)), ++link;
    return all;
  }

 private:
  const config::Job& job_;
  bool under_tilt_ = false, under_rotary_ = false, over_rotary_ = false, over_tilt_ = false;
  int bed_ = 0, fork_ = 0, head_ = 0;
};

/// Between two discs, square to `axis`, of these radii at these heights over `base`; a ball instead of the
/// lower one where `ball`.
Convex turned_body(Vec3 base, Vec3 axis, double low, double r_low, double high, double r_high,
                   bool ball = false) {
  const auto rim = [=](Vec3 u, double height, double radius) {
    const Vec3 aside = u - axis * dot(u, axis);
    const double long_ = length(aside);
    return base + axis * height + (long_ > 0.0 ? aside * (radius / long_) : Vec3{});
  };
  const auto furthest = [=](Vec3 u) {
    const Vec3 below = ball ? base + axis * (low + r_low) + normalized(u) * r_low : rim(u, low, r_low);
    const Vec3 above = rim(u, high, r_high);
    return dot(u, below) > dot(u, above) ? below : above;
  };
  return {furthest, base + axis * (0.5 * (low + high)),
          std::hypot(0.5 * (high - low), std::max(r_low, r_high))};
}

Convex points_body(std::vector<Vec3> points) {
  Vec3 low = points.front(), high = low;
  for (const Vec3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3 centre = (low + high) * 0.5;
  const double radius = 0.5 * length(high - low);
  return {[points = std::move(points)](Vec3 u) {
            return *std::max_element(points.begin(), points.end(),
                                     [&](Vec3 p, Vec3 q) { return dot(u, p) < dot(u, q); });
          },
          centre, radius};
}

/// `home`: where the shape's coordinates begin.
Convex shape_body(const config::SolidShape& shape, const Frame& home) {
  const Frame frame = home.then({shape.rotation, shape.at});
  if (shape.kind != config::SolidKind::kBox) {
    const double upper = shape.kind == config::SolidKind::kCone ? shape.upper_diameter : shape.diameter;
    return turned_body(frame.shift, frame.turn * Vec3{0, 0, 1}, 0.0, 0.5 * shape.diameter, shape.height,
                       0.5 * upper);
  }
  std::vector<Vec3> corners;
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {0.0, 1.0})
        corners.push_back(frame.turn * Vec3{x * shape.size.x, y * shape.size.y, z * shape.size.z} +
                          frame.shift);
  return points_body(std::move(corners));
}

std::vector<Group> groups_of(const config::Job& job, const Chain& chain, const pathgen::CheckedMesh& part) {
  constexpr std::array<const char*, 9> kWords{"bed",    "x slide", "y slide", "z slide", "table",
                                              "cradle", "fork",    "head",    "nose"};
  std::vector<Group> groups;
  const auto group = [&](const std::string& word) -> Group& {
    for (Group& one : groups)
      if (one.word == word) return one;
    return groups.emplace_back(Group{word, 0, 0.0, false, false, false, {}});
  };
  const config::Clearances& c = job.machine.solid.clearances;
  const Vec3 centre = from_origin(job.machine.model.table_centre);
  const int bed = chain.link(config::BodyLink::kBed);
  for (const config::MachineBody& body : job.machine.solid.bodies) {
    Group& one = group(kWords[static_cast<std::size_t>(body.link)]);
    const bool turns = body.link == config::BodyLink::kTable || body.link == config::BodyLink::kCradle;
    one.link = chain.link(body.link), one.machine = true;
    one.clearance = one.link <= bed ? c.table : c.head;
    one.bodies.push_back(shape_body(body.shape, {{}, turns ? centre : Vec3{}}));
  }
  const Frame table{{}, centre}, on_part = table.then({job.setup.fixture, job.setup.part_zero});
  for (const config::Fixture& one : job.fixtures)
    group("fixture").bodies.push_back(shape_body(one.shape, one.on_part ? on_part : table));
  if (!job.machine.solid.bodies.empty()) {
    std::vector<Vec3> corners;
    for (const auto& v : part.mesh.vertices) corners.push_back(on_part.turn * from_origin(v) + on_part.shift);
    Group& held = group("part");
    held.part = true;
    held.bodies.push_back(points_body(std::move(corners)));
  }
  const pathgen::Cutter& cutter = job.plan.cutter;
  const Vec3 up = job.machine.model.spindle, tip = up * -job.setup.tool_length;
  double at = cutter.shank_length;
  Group& edge = group("cutter");
  edge.bodies.push_back(turned_body(tip, up, 0.0, 0.5 * cutter.diameter, at, 0.5 * cutter.diameter, true));
  edge.tool = true, edge.clearance = c.cutter, edge.link = chain.links() - 1;
  Group& holder = group("holder");
  holder.tool = true, holder.clearance = c.holder, holder.link = chain.links() - 1;
  for (const auto& step : cutter.holder) {
    holder.bodies.push_back(
        turned_body(tip, up, at, 0.5 * step.lower_diameter, at + step.length, 0.5 * step.upper_diameter));
    at += step.length;
  }
  return groups;
}

bool exempt(const Group& a, const Group& b) {
  if (a.link == b.link) return true;
  if (a.machine && b.machine) return std::abs(a.link - b.link) <= 1;
  return (a.tool && b.part) || (a.part && b.tool);
}

/// A body at its place, for FCL.
struct Placed {
  const Convex& body;
  const Frame& frame;
};

extern "C" void support_of(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const auto& placed = *static_cast<const Placed*>(object);
  const Vec3 u{direction->v[0], direction->v[1], direction->v[2]};
  const Vec3 p =
      placed.frame.turn * placed.body.furthest(transposed(placed.frame.turn) * u) + placed.frame.shift;
  ccdVec3Set(point, p.x, p.y, p.z);
}

/// 0: they meet.
double distance(const Convex& a, const Frame& fa, const Convex& b, const Frame& fb) {
  Placed one{a, fa}, other{b, fb};
  double apart = 0.0;
  fcl::detail::GJKDistance<double>(&one, support_of, &other, support_of, kMostLooks, kSure, &apart, nullptr,
                                   nullptr);
  return std::max(0.0, apart);
}

using Pair = std::pair<std::size_t, std::size_t>;

/// "head \"head\"" to "head"; cutter and shank are one body here.
std::string word_of(const std::string& told) {
  const std::string word = told.substr(0, told.find(" \""));
  return word.starts_with("shank") || word.starts_with("cutter") ? "cutter" : word;
}

using Words = std::pair<std::string, std::string>;

/// Two bodies that came too near to each other.
bool names(const Collisions& found, const Words& words) {
  return std::any_of(found.places.begin(), found.places.end(), [&](const CollisionPlace& place) {
    return Words(std::minmax(word_of(place.first), word_of(place.second))) == words;
  });
}

int run(const std::string& job_file, const std::string& program) {
  const auto job = config::load_job(job_file);
  if (!job) return std::printf("%s\n", job.error().message.c_str()), 1;
  const auto part = pathgen::check_mesh(*pathgen::read_stl(job->stl_path, 1.0));
  const auto check = CollisionCheck::make(*part, *job);
  if (!part || !check) return 1;
  ControlReader reader(job->machine, job->setup);
  const MoveFrames frames(job->machine.model, job->setup);
  std::ifstream in(program);
  std::vector<ControlBlock> blocks;
  for (std::string line; std::getline(in, line);)
    if (auto read = reader.read_line(line, blocks); !read)
      return std::printf("%s: %s\n", line.c_str(), read.error().message.c_str()), 1;
  std::vector<ProgramMove> moves;
  Joints at;
  bool tcp = false;
  for (const ControlBlock& one : blocks) {
    if (one.block.op != Op::kRapid && one.block.op != Op::kFeed) continue;
    if (one.tcp != tcp) at = one.tcp ? frames.tip_words(at) : frames.slide_words(at);
    tcp = one.tcp;
    if (!one.fresh)
      moves.push_back(
          {at, one.block.target, one.block.op == Op::kRapid, tcp, one.block.line, moves.size() + 1});
    at = one.block.target;
  }
  const Chain chain(*job);
  const std::vector<Group> groups = groups_of(*job, chain, *part);
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < groups.size(); ++a)
    for (std::size_t b = a + 1; b < groups.size(); ++b)
      if (!exempt(groups[a], groups[b])) pairs.emplace_back(a, b);
  struct Count {
    std::size_t clear = 0, hit = 0, missed = 0, wrong = 0, blocks_hit = 0;
    double nearest = kInfinity;
    std::string near;  // "[line, body, body, room], " of each pair that is nearer than asked
  };
  std::vector<Count> counts(moves.size());
  tbb::parallel_for(std::size_t{0}, moves.size(), [&](std::size_t i) {
    const ProgramMove& move = moves[i];
    std::set<Words> told;
    for (const CollisionPlace& place : check->hold(std::span(&move, 1), 0).places)
      told.insert(std::minmax(word_of(place.first), word_of(place.second)));
    std::vector<double> rooms(pairs.size(), kInfinity), moved(pairs.size(), 0.0);
    std::vector<double> least;  // by pair of bodies: no nearer than this at the place, mm
    std::vector<Frame> before;
    const double turned =
        2.0 *
        Angle::from_degrees(std::abs(move.to.a - move.from.a) + std::abs(move.to.c - move.from.c)).radians() /
        kPlaces;
    for (int k = 0; k < kPlaces; ++k) {
      const double share = static_cast<double>(k) / (kPlaces - 1);
      const auto mix = [&](double p, double q) { return p + share * (q - p); };
      Joints words{mix(move.from.x, move.to.x), mix(move.from.y, move.to.y), mix(move.from.z, move.to.z),
                   mix(move.from.a, move.to.a), mix(move.from.c, move.to.c)};
      if (move.tcp) words = frames.slide_words(words);
      const std::vector<Frame> now = chain.frames(words);
      std::size_t bodies = 0;
      for (std::size_t p = 0; p < pairs.size(); ++p) {
        const Group &a = groups[pairs[p].first], &b = groups[pairs[p].second];
        const Frame &fa = now[static_cast<std::size_t>(a.link)], &fb = now[static_cast<std::size_t>(b.link)];
        const double asked = std::max(a.clearance, b.clearance) *
                             (move.rapid ? job->machine.solid.clearances.rapid_factor : 1.0);
        for (const Convex& one : a.bodies)
          for (const Convex& other : b.bodies) {
            const Vec3 middle = fa.turn * one.centre + fa.shift;
            const double apart =
                length(middle - fb.turn * other.centre - fb.shift) - one.radius - other.radius;
            const std::size_t at_hand = bodies++;
            if (least.size() == at_hand) least.push_back(0.0);
            double &bound = least[at_hand], step = 0.0;
            if (!before.empty()) {
              // How far the one goes from place to place, seen from the other.
              const Frame &ga = before[static_cast<std::size_t>(a.link)],
                          &gb = before[static_cast<std::size_t>(b.link)];
              const Vec3 seen = transposed(fb.turn) * (middle - fb.shift),
                         was = transposed(gb.turn) * (ga.turn * one.centre + ga.shift - gb.shift);
              step = length(seen - was) + one.radius * turned;
              if (apart <= kFar) moved[p] = std::max(moved[p], step);
              bound -= step;
            }
            bound = std::max(bound, apart);
            if (apart <= kFar && bound - asked < std::min(rooms[p], kNear + 2.0 * step))
              bound = distance(one, fa, other, fb);
            rooms[p] = std::min(rooms[p], bound - asked);
          }
      }
      before = now;
    }
    Count& count = counts[i];
    ProgramMove begun = move;
    begun.to = move.from;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const Words words = std::minmax(groups[pairs[p].first].word, groups[pairs[p].second].word);
      // A move that begins and ends inside a body meets no surface: both ends are looked at as a first place
      // is.
      if (rooms[p] < -2.0 * kSure && told.count(words) == 0 && names(check->look(begun), words) &&
          names(check->look(move), words))
        told.insert(words);
      const bool hit = told.count(words) > 0;
      count.nearest = std::min(count.nearest, rooms[p]);
      if (rooms[p] < kTold + moved[p])
        count.near += text("[%u, \"%s\", \"%s\", %.3f], ", move.line, groups[pairs[p].first].word.c_str(),
                           groups[pairs[p].second].word.c_str(), rooms[p]);
      if (hit && rooms[p] > kTold + moved[p])
        ++count.wrong;
      else if (!hit && rooms[p] < -2.0 * kSure)
        ++count.missed;
      else
        ++(hit ? count.hit : count.clear);
      if (hit) count.blocks_hit = 1;
    }
  });
  Count all;
  for (const Count& one : counts) {
    all.clear += one.clear, all.hit += one.hit, all.missed += one.missed, all.wrong += one.wrong;
    all.blocks_hit += one.blocks_hit, all.nearest = std::min(all.nearest, one.nearest);
    if (all.near.size() < kMostTold) all.near += one.near;
  }
  std::printf(
      "{\"blocks\": %zu, \"blocks_hit\": %zu, \"pairs\": %zu, \"clear\": %zu, \"hit\": %zu, \"missed\": %zu, "
      "\"wrong\": %zu, \"least_room_mm\": %.3f, \"near\": [%snull]}\n",
      moves.size(), all.blocks_hit, pairs.size(), all.clear, all.hit, all.missed, all.wrong,
      std::isfinite(all.nearest) ? all.nearest : kFar, all.near.c_str());
  return all.missed + all.wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace tiltfeed::sim

int main(int argc, char** argv) {
  if (argc == 3) return tiltfeed::sim::run(argv[1], argv[2]);
  std::fprintf(stderr, "collision_places JOB PROGRAM\n");
  return 2;
}
