// Which ways of an operation's program have other choices: that by the machine's retract where the program
// has one, the swing from the operation before, a rotary that turns back at the retract.

#include "daemon/plan/operation_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "config/machine_profile.h"
#include "sim/motion/forward.h"
#include "tests/shapes/box_mesh.h"
#include "tests/texts/folder.h"

namespace tiltfeed::daemon {
namespace {

const std::size_t kAtRetract = static_cast<std::size_t>(
    std::find_if(kLinkChoices.begin(), kLinkChoices.end(), [](const auto& one) { return one.at_retract; }) -
    kLinkChoices.begin());

/// Rows over a box, with a rapid between each two. `machine`: further lines of the profile's program.
config::Job rows_job(const std::string& machine, config::Dialect dialect, const std::string& axis) {
  const std::string profile = SOURCE_DIR "/config/machines/" + machine + ".yaml";
  const std::string text =
      "part: {name: box, stl: box.stl}\n"
      "cutter: {type: ball, diameter_mm: 6, length_mm: 60, shank_length_mm: 30}\n"
      "axis: " +
      axis +
      "\npattern: {direction: one_way, side_step_mm: 5}\ntolerance_mm: 0.02\nclearance_mm: 5\napproach_mm: "
      "1\nprogram: {tool: 1}\nfeeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 500}\n"
      "setup: {part_zero_mm: [0, 0, 100]}\nmachine: " +
      profile + "\n";
  auto job = config::parse_job(text, SOURCE_DIR "/config/jobs/t.yaml");
  EXPECT_TRUE(job) << job.error().message;
  auto of_dialect = config::load_machine(profile, dialect);
  EXPECT_TRUE(of_dialect) << of_dialect.error().message;
  job->machine = *of_dialect;
  return *job;
}

const std::string kLeaning = "{mode: fixed, n: [0.3, 0, 1], t: [0, 1, 0]}";

/// An operation with its path and joints.
struct Planned {
  explicit Planned(const config::Job& job) : plan(job, clock, told) {
    pathgen::Stl stl;
    const pathgen::Mesh box = box_mesh({{{{-20, -15, 0}, {20, 15, 20}}}});
    for (const auto& facet : box.facets) {
      stl.facets.push_back({});
      for (std::size_t k = 0; k < 3; ++k) stl.facets.back()[k] = box.vertices[facet[k]];
    }
    auto part = pathgen::check_mesh(stl);
    EXPECT_TRUE(part) << part.error().message;
    const auto path =
        plan.plan_path(std::make_shared<pathgen::CheckedMesh>(std::move(*part)), pathgen::PartModel{}, false);
    EXPECT_TRUE(path) << path.error().message;
    joints();
  }
  void joints() {
    const auto found = plan.find_joints();
    EXPECT_TRUE(found) << found.error().message;
  }
  StageClock clock;
  PlanListener told;
  OperationPlan plan;
};

/// A link between two cuts has a way by the retract where the program has a retract, and where its control
/// does not turn the table home first.
TEST(OperationPlan, ALinkGoesByTheRetractOnlyWhereThereIsOne) {
  using config::Dialect;
  const struct {
    const char* machine;
    Dialect dialect;
    bool tcp;
    const char* retract;
    bool goes;
  } table[]{{"generic-ac", Dialect::kRs274, false, "default", true},
            {"generic-ac", Dialect::kRs274, false, "none", false},
            {"generic-ac", Dialect::kFanuc, false, "default", true},
            {"generic-ac", Dialect::kFanuc, true, "default", false},
            {"generic-ac", Dialect::kHaas, true, "default", false},
            {"generic-ac", Dialect::kSiemens, true, "default", true},
            {"generic-ac", Dialect::kHeidenhain, true, "none", false},
            // Both rotaries in the head: no table turns home.
            {"linuxcnc-bridge-bc", Dialect::kFanuc, true, "default", true}};
  for (const auto& one : table) {
    config::Job job = rows_job(one.machine, one.dialect, kLeaning);
    job.machine.format.tcp = one.tcp;
    job.machine.format.retract = one.retract;
    const Planned planned(job);
    const std::size_t links = planned.plan.link_choices().size();
    ASSERT_GT(links, 3u);
    EXPECT_EQ(planned.plan.link_differs(1, kAtRetract), one.goes)
        << one.machine << " " << config::name_of(one.dialect).name << " " << one.tcp << " " << one.retract;
    EXPECT_TRUE(planned.plan.link_differs(1, 1));
    // The program's own beginning and end are at the retract.
    EXPECT_FALSE(planned.plan.link_differs(0, kAtRetract));
    EXPECT_FALSE(planned.plan.link_differs(links - 1, kAtRetract));
  }
}

/// The swing from the operation before is known by its words, and has other ways; the stretch begins there.
TEST(OperationPlan, TheSwingFromTheOperationBeforeHasOtherWays) {
  config::Job job = rows_job("generic-ac", config::Dialect::kSiemens, kLeaning);
  Planned planned(job);
  OperationPlan& plan = planned.plan;
  const MachineModel& machine = job.machine.model;
  const Joints usual = plan.joints().moves.front().joints;
  EXPECT_FALSE(plan.swing_differs(0, 1)) << "there is no operation before";
  const Joints from{usual.x + 40, usual.y - 20, usual.z, usual.a + 15, usual.c - 120};
  plan.come_from(from);
  planned.joints();
  EXPECT_EQ(plan.joints().moves.front().joints, usual);
  // Half way, the rotaries together and X Y where they were.
  Joints middle{from.x, from.y, machine.z.max, 0.5 * (from.a + usual.a), 0.5 * (from.c + usual.c)};
  EXPECT_EQ(plan.link_at(middle, true), (LinkPlace{0, true}));
  EXPECT_EQ(plan.link_at(middle, false), std::nullopt) << "no feed swings";
  middle.a = from.a;
  EXPECT_EQ(plan.link_at(middle, true), std::nullopt);
  std::size_t ways = 0, sides = 0, rounds = 0;
  for (std::size_t choice = 1; choice < kSwingChoices.size(); ++choice) {
    if (!plan.swing_differs(0, choice)) continue;
    ++ways;
    std::vector<std::size_t> swings(plan.swing_choices().size(), 0);
    swings.front() = choice;
    plan.choose_links(plan.link_choices(), swings);
    planned.joints();
    const Joints first = plan.joints().moves.front().joints;
    const SwingChoice& chosen = kSwingChoices[choice];
    sides += chosen.other_side, rounds += chosen.other_way;
    EXPECT_EQ(first.a * usual.a < 0.0, chosen.other_side) << choice;
    if (!chosen.other_side) {
      EXPECT_NEAR(std::abs(first.c - usual.c), chosen.other_way ? 360.0 : 0.0, 1e-9) << choice;
    }
    EXPECT_EQ(plan.posted({}).posting.operations.front().way, chosen.way) << choice;
    // The tool is where it was, by the simulated machine's own chain.
    const Pose is = sim::forward_by_frames(machine, job.setup, first),
               was = sim::forward_by_frames(machine, job.setup, usual);
    EXPECT_LT(distance(is.tip, was.tip), 0.01) << choice;
    EXPECT_LT(length(is.axis - was.axis), 1e-4) << choice;
  }
  EXPECT_GT(ways, 20u);
  EXPECT_TRUE(sides > 0 && rounds > 0);
  // The other way round is another from another side.
  const auto round = static_cast<std::size_t>(
      std::find_if(kSwingChoices.begin(), kSwingChoices.end(),
                   [](const SwingChoice& one) { return one.other_way && !one.other_side; }) -
      kSwingChoices.begin());
  std::vector<std::size_t> swings(plan.swing_choices().size(), 0);
  swings.front() = round;
  plan.choose_links(plan.link_choices(), swings);
  planned.joints();
  EXPECT_NEAR(plan.joints().moves.front().joints.c - usual.c, -360.0, 1e-9);
  plan.come_from(Joints{from.x, from.y, from.z, from.a, usual.c + 120});
  planned.joints();
  EXPECT_NEAR(plan.joints().moves.front().joints.c - usual.c, 360.0, 1e-9);
  // Without an operation before the joints are those as planned.
  plan.choose_links(plan.link_choices(), std::vector<std::size_t>(plan.swing_choices().size(), 0));
  plan.come_from(std::nullopt);
  planned.joints();
  EXPECT_EQ(plan.joints().moves.front().joints, usual);
  job.machine.format.retract = "none";
  Planned none(job);
  none.plan.come_from(from);
  EXPECT_FALSE(none.plan.swing_differs(0, 1));
}

std::vector<Pose> poses_of_cuts(const ToolPath& path) {
  std::vector<Pose> cuts;
  for (const Move& move : path.moves)
    if (move.kind == MoveKind::kCut) cuts.push_back(move.pose);
  return cuts;
}

/// In the middle of a cut, and in a link: the program is in stretches there, and cuts what it did.
TEST(OperationPlan, ARotaryTurnsBackAtTheRetract) {
  const config::Job job = rows_job("generic-ac", config::Dialect::kSiemens, kLeaning);
  for (const bool in_cut : {true, false}) {
    Planned planned(job);
    OperationPlan& plan = planned.plan;
    const std::vector<Move> moves = plan.cl_path().moves;
    const std::size_t links = plan.link_choices().size();
    const std::vector<Pose> cuts = poses_of_cuts(plan.block_path());
    const auto plunges = [&] {
      const std::vector<Move>& all = plan.block_path().moves;
      return std::count_if(all.begin(), all.end(),
                           [](const Move& move) { return move.kind == MoveKind::kPlunge; });
    };
    const auto plunged = plunges();
    std::size_t behind = moves.size() / 3;
    const auto cut = [&](std::size_t i) { return moves[i].kind == MoveKind::kCut; };
    // Whether or not the path has a way in front: two of a kind on both sides.
    while (!(in_cut ? cut(behind - 2) && cut(behind - 1) && cut(behind) && cut(behind + 1) && cut(behind + 2)
                    : !cut(behind - 1) && !cut(behind) && !cut(behind + 1)))
      ++behind;
    EXPECT_TRUE(plan.turns_back().empty()) << "no rotary turns back by itself";
    ASSERT_TRUE(plan.turn_at_retract({behind}));
    planned.joints();
    EXPECT_EQ(plan.link_choices().size(), links + (in_cut ? 1 : 0));
    const auto& choices = plan.link_choices();
    ASSERT_EQ(std::count(choices.begin(), choices.end(), kAtRetract), 1);
    const auto turned =
        static_cast<std::size_t>(std::find(choices.begin(), choices.end(), kAtRetract) - choices.begin());
    for (std::size_t i = 0; i < choices.size(); ++i)
      EXPECT_EQ(plan.least_choice(i), i == turned ? kAtRetract : 0) << i;
    EXPECT_TRUE(plan.in_stretches());
    EXPECT_EQ(plan.posted({}).posting.operations.size(), 2u);
    EXPECT_EQ(poses_of_cuts(plan.block_path()), cuts);
    // In a cut it comes back to where it went off, by a plunge; a link has its own.
    EXPECT_EQ(plunges(), plunged + (in_cut ? 1 : 0));
    const LinkWay way = link_ways(plan.block_path())[turned];
    const std::vector<Move>& made = plan.block_path().moves;
    if (in_cut) {
      EXPECT_EQ(made[way.end - 1].pose, made[way.begin - 1].pose);
    }
    // Between the stretches the machine is at the end of Z's travel.
    const std::vector<JointMove>& joints = plan.joints().moves;
    const auto up = std::find_if(joints.begin() + 1, joints.end() - 1, [&](const JointMove& move) {
      return move.joints.z == job.machine.model.z.max;
    });
    EXPECT_NE(up, joints.end() - 1);
  }
  config::Job none = job;
  none.machine.format.retract = "none";
  Planned planned(none);
  EXPECT_FALSE(planned.plan.turn_at_retract({planned.plan.cl_path().moves.size() / 2}));
}

}  // namespace
}  // namespace tiltfeed::daemon
