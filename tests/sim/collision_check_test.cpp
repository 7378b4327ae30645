// Collisions along a program against dense sampling by the simulated machine's own chain and all pairs of
// facets; the bounds that the search leans on against random places of the axes.

#include "sim/collision/collision_check.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/shapes/collision_shop.h"

namespace tiltfeed::sim {
namespace {

using config::BodyLink;

struct JointDice {
  std::mt19937_64 random;
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  Joints near(double size, double turn) {
    return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size), (*this)(-turn, turn),
            (*this)(-2 * turn, 2 * turn)};
  }
};

const std::vector<std::string> kMachines{"generic-ac",      "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc",
                                         "mill-4x-table-a", "mill-4x-head-b",       "dmu-nutating-bc"};

/// With absent axes at home.
Joints on(const MachineModel& model, Joints j) {
  if (!model.tilt.present) j.a = 0.0;
  if (!model.rotary.present) j.c = 0.0;
  return j;
}

TEST(MachineLine, PutsTheToolWhereTheSimulatedMachineDoes) {
  JointDice dice{std::mt19937_64(7)};
  for (const std::string& name : kMachines) {
    config::Job job = bare_job(name);
    for (const std::vector<int>& work : {std::vector<int>{}, {0}, {1, 0}, {0, 1, 2}}) {
      job.machine.solid.work_slides = work;
      job.machine.solid.tool_slides.clear();
      for (int axis = 0; axis < 3; ++axis)
        if (std::find(work.begin(), work.end(), axis) == work.end())
          job.machine.solid.tool_slides.push_back(axis);
      job.machine.model.table_centre = {11, -7, 5};
      job.setup.fixture = rotation_about(normalized(Vec3{1, 2, 3}), 0.7);
      const MachineLine line(job.machine, job.setup);
      for (int i = 0; i < 20; ++i) {
        const Joints words = on(job.machine.model, dice.near(100.0, 90.0));
        const Placement tool =
            inverse(line.part()) * line.relative(words_of(words), line.work(), line.tool());
        const Pose pose = forward_by_frames(job.machine.model, job.setup, words);
        const Vec3 tip = tool(line.tip()({})), up = tool(line.tip()({0, 0, 1}));
        EXPECT_LT(length(tip - from_origin(pose.tip)), 1e-9) << name;
        EXPECT_LT(length(up - tip - pose.axis), 1e-9) << name;
        const Vec3 corner{12, -30, 44};
        EXPECT_LT(length(tool(corner) - spindle_point(job, words, corner)), 1e-9) << name;
      }
    }
  }
}

/// Bodies on every link, so that every pair's bound is tried.
config::Job full_job(const std::string& name) {
  config::Job job = bare_job(name);
  const Structure structure = job.machine.model.structure;
  std::vector<config::MachineBody>& bodies = job.machine.solid.bodies;
  const auto add = [&](const char* body, BodyLink link, Vec3 size, Vec3 at) {
    bodies.push_back({body, link, "", box_at(size, at)});
  };
  add("bed", BodyLink::kBed, {300, 200, 20}, {0, 30, -200});
  add("x", BodyLink::kXSlide, {30, 20, 60}, {150, 10, 300});
  add("y", BodyLink::kYSlide, {30, 40, 20}, {-190, 10, 350});
  add("z", BodyLink::kZSlide, {20, 40, 60}, {0, 10, 310});
  add("table", BodyLink::kTable, {120, 90, 20}, {5, 0, -40});
  if (structure == Structure::kTableTable) add("cradle", BodyLink::kCradle, {200, 40, 20}, {0, 30, -90});
  if (structure == Structure::kHeadHead) add("fork", BodyLink::kFork, {20, 40, 120}, {70, 0, 260});
  add("head", BodyLink::kHead, {60, 50, 80}, {10, 0, 60});
  add("nose", BodyLink::kNose, {40, 30, 30}, {0, 5, 10});
  job.fixtures = {{"vice", true, "", box_at({40, 20, 30}, {10, 20, -10})}};
  return job;
}

TEST(CollisionScene, NoPairMovesFurtherThanItsBound) {
  JointDice dice{std::mt19937_64(8)};
  for (const std::string& name : kMachines) {
    const config::Job job = full_job(name);
    const auto scene = CollisionScene::make(far_part(), job);
    ASSERT_TRUE(scene) << scene.error().message;
    ASSERT_GT(scene->pairs().size(), 10u);
    double most = 0.0;
    for (const BodyPair& pair : scene->pairs()) {
      if (scene->groups()[pair.a].kind == BodyKind::kPart || scene->groups()[pair.b].kind == BodyKind::kPart)
        continue;
      for (int i = 0; i < 24; ++i) {
        const Joints p = on(job.machine.model, dice.near(200.0, 90.0)),
                     by = on(job.machine.model, dice.near(8.0, 12.0));
        AxisWords from = words_of(p), to = from, way{};
        for (std::size_t k = 0; k < way.size(); ++k) {
          if (i % 6 < 5 && i % 6 != static_cast<int>(k)) continue;  // one axis, or all
          to[k] += words_of(by)[k], way[k] = std::abs(words_of(by)[k]);
        }
        const auto distance = [&](const AxisWords& words) {
          const auto& groups = scene->groups();
          return groups[pair.a].tree.nearest(groups[pair.b].tree, scene->pose(pair, words), 1e6)->distance;
        };
        const double moved = std::abs(distance(to) - distance(from)), bound = pair.motion(way);
        EXPECT_LE(moved, bound + 1e-9)
            << name << ": " << scene->groups()[pair.a].word << " and " << scene->groups()[pair.b].word;
        if (bound > 0.0) most = std::max(most, moved / bound);
      }
    }
    EXPECT_GT(most, 0.9);  // and bodies do move as far
  }
}

TEST(CollisionScene, ATableOfRevolutionIsNotMovedByItsTurn) {
  config::Job job = bare_job("generic-ac");
  config::SolidShape disc;
  disc.kind = config::SolidKind::kCylinder, disc.diameter = disc.upper_diameter = 400, disc.height = 50;
  job.machine.solid.bodies = {{"table", BodyLink::kTable, "", disc},
                              {"nose", BodyLink::kNose, "", box_at({40, 30, 30}, {})}};
  const auto reach = [&] {
    const auto scene = CollisionScene::make(far_part(), job);
    for (const BodyPair& pair : scene->pairs())
      if (scene->groups()[pair.a].word == "table" && scene->groups()[pair.b].word == "nose")
        return pair.reach[1];
    return -1.0;
  };
  EXPECT_EQ(reach(), 0.0);
  job.machine.solid.bodies[0].shape.at = {1, 0, 0};
  EXPECT_NEAR(reach(), 201.0, 1e-9);
}

/// What the cube meets in a move; the tool under it may meet the plate, too.
Collisions of_cube(const CollisionCheck& check, const ProgramMove& move) {
  Collisions found = check.hold(std::span(&move, 1), 0);
  std::erase_if(found.places, [](const CollisionPlace& p) { return p.second != "nose \"cube\""; });
  return found;
}

/// A cube of 2 mm at the nose and a plate of 1 mm, fixed to the part.
config::Job cube_and_plate() {
  config::Job job = bare_job("generic-ac");
  job.machine.solid.bodies = {{"cube", BodyLink::kNose, "", box_at({2, 2, 2}, {30, 0, 0})}};
  job.machine.solid.clearances.head = 0.0;
  job.fixtures = {{"plate", true, "", box_at({1, 400, 400}, {30, 0, 0})}};
  return job;
}

TEST(CollisionCheck, NothingPassesThroughAPlateWithinABlock) {
  const config::Job job = cube_and_plate();
  const auto check = CollisionCheck::make(far_part(), job);
  ASSERT_TRUE(check) << check.error().message;
  for (const double long_way : {4.0, 40.0, 400.0}) {
    const ProgramMove through{{-long_way, 0, 100, 0, 0}, {1.37 * long_way, 0, 100, 0, 0}, true, false, 17, 4};
    const Collisions found = of_cube(*check, through);
    ASSERT_EQ(found.places.size(), 1u) << long_way;
    EXPECT_EQ(found.places[0].line, 17u);
    EXPECT_EQ(found.places[0].first, "fixture \"plate\"");
    EXPECT_EQ(found.places[0].second, "nose \"cube\"");
    // The first place: the cube's side comes to the plate's.
    EXPECT_NEAR(found.places[0].words[0], -1.5, 2.0 * kCollisionError + 0.02);
    const ProgramMove beside{{-long_way, 0, 320, 0, 0}, {long_way, 0, 320, 0, 0}, true, false, 18, 5};
    EXPECT_TRUE(of_cube(*check, beside).places.empty());
  }
  // A swing of the table takes the plate through the cube, which stands still.
  const ProgramMove swing{{40, 0, 100, 0, -60}, {40, 0, 100, 0, 200}, true, false, 19, 6};
  EXPECT_EQ(of_cube(*check, swing).places.size(), 1u);
}

TEST(CollisionCheck, SaysHowDeep) {
  config::Job job = cube_and_plate();
  job.fixtures[0].shape = box_at({20, 400, 400}, {30, 0, 0});
  const auto check = CollisionCheck::make(far_part(), job);
  ProgramMove in{{0, 0, 100, 0, 0}, {0, 0, 100, 0, 0}, false, false, 3, 1};
  Collisions found = check->look(in);  // wholly inside: no surface is near
  ASSERT_EQ(found.places.size(), 1u);
  check->measure(found);
  EXPECT_NEAR(found.places[0].depth, 9.0, 1e-9);
  in.to.x = in.from.x = 10.5;  // the cube reaches 0.5 mm into it
  found = check->look(in);
  ASSERT_EQ(found.places.size(), 1u);
  check->measure(found);
  EXPECT_NEAR(found.places[0].depth, 0.5, 1e-9);
  in.to.x = in.from.x = 11.5;
  EXPECT_TRUE(check->look(in).places.empty());
  job.machine.solid.clearances.head = 0.8;
  const auto wide = CollisionCheck::make(far_part(), job);
  found = wide->look(in);
  ASSERT_EQ(found.places.size(), 1u);
  EXPECT_NEAR(found.places[0].apart, 0.5, 1e-9);
  EXPECT_NE(wide->text(found, "p.nc")
                .find("p.nc:3: collision: fixture \"plate\" and nose \"cube\", 0.500 mm apart"),
            std::string::npos)
      << wide->text(found, "p.nc");
}

/// A fixture's and a nose's corners at places of a program; each block either collides by both or by neither.
void compare_with_sampling(const std::string& name, std::uint64_t seed, double room) {
  JointDice dice{std::mt19937_64(seed)};
  config::Job job = bare_job(name);
  const Vec3 turned{dice(-1, 1), dice(-1, 1), dice(-1, 1)};
  const config::SolidShape nose = box_at({40, 30, 50}, {5, 0, 0}, {0.1, 0.2, 0.3}),
                           vice = box_at({60, 30, 40}, {dice(-30, 30), dice(-30, 30), 20}, turned);
  job.machine.solid.bodies = {{"nose", BodyLink::kNose, "", nose}};
  job.machine.solid.clearances.head = room;
  job.fixtures = {{"vice", true, "", vice}};
  const auto check = CollisionCheck::make(far_part(), job);
  ASSERT_TRUE(check) << check.error().message;
  const SolidMesh head = *mesh_of(nose), fixed = *mesh_of(vice);
  const std::vector<Corners> work = facets_of(fixed);
  int clear = 0, hit = 0;
  Joints from = on(job.machine.model, dice.near(120.0, 80.0));
  for (std::uint32_t block = 1; block <= 14; ++block) {
    Joints to = on(job.machine.model, dice.near(120.0, 80.0));
    to.z -= 60.0;
    const bool rapid = block % 2 == 0;
    double least = kInfinity;
    constexpr int kSamples = 150;
    for (int i = 0; i <= kSamples; ++i) {
      const double f = static_cast<double>(i) / kSamples;
      const Joints at{from.x + f * (to.x - from.x), from.y + f * (to.y - from.y),
                      from.z + f * (to.z - from.z), from.a + f * (to.a - from.a),
                      from.c + f * (to.c - from.c)};
      SolidMesh moved = head;
      for (Vec3& v : moved.vertices) v = spindle_point(job, at, v);
      least = std::min(least, brute_distance(facets_of(moved), work));
    }
    const ProgramMove move{from, to, rapid, false, block, block};
    const Collisions found = check->hold(std::span(&move, 1), 0);
    const bool collides = std::any_of(found.places.begin(), found.places.end(), [](const CollisionPlace& p) {
      return p.first == "fixture \"vice\"" && p.second == "nose \"nose\"";
    });
    const double asked = rapid ? 2.0 * room : room;
    // Between samples they come nearer by up to some mm: what is only just clear is not compared.
    if (least <= asked) {
      EXPECT_TRUE(collides) << name << " block " << block << ": " << least << " mm";
      ++hit;
    } else if (least > asked + 6.0) {
      EXPECT_FALSE(collides) << name << " block " << block << ": " << least << " mm";
      ++clear;
    }
    from = to;
  }
  EXPECT_GT(hit + clear, 5);
}

TEST(CollisionCheck, AgreesWithDenseSampling) {
  std::uint64_t seed = 100;
  for (const std::string& name : kMachines) {
    ++seed;
    compare_with_sampling(name, seed, seed % 2 == 0 ? 3.0 : 0.5);
  }
}

TEST(CollisionCheck, ManyMovesGiveTheSameInAnyGrouping) {
  const config::Job job = cube_and_plate();
  std::vector<ProgramMove> moves;
  JointDice dice{std::mt19937_64(5)};
  Joints from{-50, 0, 100, 0, 0};
  for (std::uint32_t i = 0; i < 400; ++i) {
    const Joints to{from.x + dice(-3, 3.4), from.y + dice(-3, 3), 100.0 + dice(-1, 1), dice(-5, 5),
                    from.c + dice(-3, 3)};
    moves.push_back({from, to, i % 10 == 0, false, i, i});
    from = to;
  }
  const auto together = CollisionCheck::make(far_part(), job), apart = CollisionCheck::make(far_part(), job);
  const Collisions all = together->hold(moves, 0);
  Collisions some;
  for (std::size_t at = moves.size(); at > 0; at -= 50)  // the last first: cells are asked in another order
    apart->hold(std::span(moves).subspan(at - 50, 50), 0);
  for (std::size_t at = 0; at < moves.size(); at += 50)
    some.add(apart->hold(std::span(moves).subspan(at, 50), CollisionCheck::told(some)));
  ASSERT_EQ(all.places.size(), some.places.size());
  EXPECT_GT(all.places.size(), 0u);
  for (std::size_t i = 0; i < all.places.size(); ++i) {
    EXPECT_EQ(all.places[i].line, some.places[i].line);
    EXPECT_EQ(all.places[i].words, some.places[i].words);
  }
}

}  // namespace
}  // namespace tiltfeed::sim
