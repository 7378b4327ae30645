// Machines with one rotary axis or none: the posture that comes nearest against a search over all, programs
// by the simulated machine's own kinematics, and what they refuse.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "daemon/journal/reentry.h"
#include "daemon/machine/machine_place.h"
#include "daemon/stream/stream.h"
#include "kinematics/machine/chain.h"
#include "sim/motion/forward.h"
#include "tests/judges/apt_judge.h"
#include "tests/peers/ring_wire.h"
#include "tests/texts/folder.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

MachineProfile shipped(const std::string& name) {
  const auto profile = load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml");
  EXPECT_TRUE(profile) << profile.error().message;
  return profile.value_or(MachineProfile{});
}

const std::vector<std::string> kMachines{"mill-3x", "mill-4x-table-a", "mill-4x-head-b"};

TEST(FewerAxes, ThePostureIsTheNearestOfAll) {
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  for (const std::string& name : kMachines) {
    const MachineModel machine = shipped(name).model;
    const Chain chain(machine, {});
    for (int round = 0; round < 200; ++round) {
      const Vec3 axis = normalized(Vec3{normal(random), normal(random), normal(random)});
      double least = 4.0;
      for (double word = -180.0; word < 180.0; word += 0.5) {
        const Joints q{0, 0, 0, machine.tilt.present ? word : 0.0, machine.rotary.present ? word : 0.0};
        least = std::min(least, angle_between(sim::forward_by_frames(machine, {}, q).axis, axis));
      }
      const AxisSolutions found = chain.solve_axis(axis);
      EXPECT_NEAR(found.missed, least, 0.01) << name;
      const Joints q{0, 0, 0, chain.tilt_word(found.angles[0].tilt),
                     chain.rotary_word(found.angles[0].rotary)};
      EXPECT_NEAR(angle_between(sim::forward_by_frames(machine, {}, q).axis, axis), found.missed, 1e-12);
      EXPECT_EQ(machine.tilt.present || q.a == 0.0, true);
      EXPECT_EQ(machine.rotary.present || q.c == 0.0, true);
    }
  }
}

/// A path on a cylinder about `line`, the tool square to it, and the corners that it must pass.
AptOperation about(Vec3 line, double from_deg, double to_deg, std::vector<Corner>& corners) {
  AptOperation op;
  op.tool_number = 3;
  op.path.tool = {6, 3, 80};
  op.path.cut_feed = op.path.plunge_feed = Feed::from_mm_per_min(900);
  const int steps = from_deg == to_deg ? 4 : 40;
  for (int i = 0; i <= steps; ++i) {
    const double angle = Angle::from_degrees(from_deg + (to_deg - from_deg) * i / steps).radians();
    const Vec3 axis = rotation_about(line, angle) * Vec3{0, 0, 1};
    const Vec3 tip = axis * 20.0 + line * (1.0 * i);
    op.path.moves.push_back(
        {{{tip.x, tip.y, tip.z}, axis}, i == 0 ? MoveKind::kRapid : MoveKind::kCut, kNoFacet});
    op.lines.push_back(static_cast<std::uint32_t>(i + 1));
    corners.push_back({{tip.x, tip.y, tip.z}, axis, i == 0 ? 0.0 : 900.0});
  }
  return op;
}

TEST(FewerAxes, ProgramsAreRightByTheSimulatedMachinesKinematics) {
  const struct {
    const char* machine;
    Vec3 line;
    double from, to;
    const char* without;  ///< letters that no block may have
  } table[]{{"mill-3x", {0, 1, 0}, 0, 0, "ABC"},
            {"mill-4x-table-a", {1, 0, 0}, -170, 400, "BC"},
            {"mill-4x-table-a", {1, 0, 0}, 0, 0, "BC"},
            {"mill-4x-head-b", {0, 1, 0}, -95, 95, "AC"}};
  for (const auto& row : table)
    for (const DialectName& control : kDialects) {
      SCOPED_TRACE(std::string(row.machine) + " " + control.name);
      MachineProfile profile = shipped(row.machine);
      profile.format = usual_format(control.dialect);
      PostOptions options;
      options.setup.part_zero = {3, -4, 5};
      std::vector<Corner> corners;
      AptProgram program;
      program.operations.push_back(about(row.line, row.from, row.to, corners));
      const auto text = program_text(program, profile, options);
      ASSERT_TRUE(text) << text.error().message;
      std::istringstream in(*text);
      const auto read = read_nc_program(in, "p.nc", text_language(profile));
      ASSERT_TRUE(read) << read.error().message;
      AptProgram made;
      made.operations.emplace_back();
      tiltfeed::Setup placed = options.setup;
      placed.tool_length = 80;
      Joints at;
      for (const TextBlock& block : read->operations[0].blocks) {
        for (const double f : {0.25, 0.5, 0.75, 1.0}) {
          const auto part = [&](double p, double q) { return p + f * (q - p); };
          const Joints q{part(at.x, block.words.x), part(at.y, block.words.y), part(at.z, block.words.z),
                         part(at.a, block.words.a), part(at.c, block.words.c)};
          if (f < 1.0 && block.rapid) continue;
          made.operations[0].path.moves.push_back({sim::forward_by_frames(profile.model, placed, q),
                                                   block.rapid ? MoveKind::kRapid : MoveKind::kCut,
                                                   kNoFacet});
        }
        at = block.words;
      }
      made.operations[0].path.cut_feed = Feed::from_mm_per_min(900);
      WayOfProgram(made, 0.007, 0.06).expect(corners);
      std::istringstream lines(*text);
      for (std::string line; std::getline(lines, line);) {
        for (std::size_t i = 0; i + 2 < line.size() && line.find_first_of("(;") == std::string::npos; ++i) {
          const bool word =
              line[i] == ' ' && std::string("+-.0123456789").find(line[i + 2]) != std::string::npos;
          EXPECT_FALSE(word && std::string(row.without).find(line[i + 1]) != std::string::npos) << line;
        }
      }
    }
}

TEST(FewerAxes, WhatNeedsMoreIsRefusedByName) {
  const struct {
    const char* machine;
    Vec3 line;
    const char* message;
  } table[]{{"mill-3x", {0, 1, 0}, "10 degrees from the nearest that mill-3x gives: it has no rotary axis"},
            {"mill-4x-table-a", {0, 1, 0}, "of the rotary axes it has A alone"},
            {"mill-4x-head-b", {1, 0, 0}, "of the rotary axes it has B alone"}};
  for (const auto& row : table) {
    std::vector<Corner> corners;
    AptProgram program;
    program.operations.push_back(about(row.line, 10, 10, corners));
    const auto text = program_text(program, shipped(row.machine), {});
    ASSERT_FALSE(text) << row.machine;
    EXPECT_EQ(text.error().code, Code::kUnreachable);
    EXPECT_NE(text.error().message.find(row.message), std::string::npos) << text.error().message;
  }
}

TEST(FewerAxes, DirectionsThatLeanByTheirLastDecimalStandUpright) {
  std::vector<Corner> corners;
  AptProgram program;
  program.operations.push_back(about({0, 1, 0}, 0.0003, 0.0003, corners));
  for (const std::string& name : kMachines) {
    MachineProfile profile = shipped(name);
    profile.format.rotary_decimals = 6;
    const auto text = program_text(program, profile, {});
    EXPECT_TRUE(text) << text.error().message;
  }
}

/// What the axes do is known without any of our readers: the program is made from it.
TEST(FewerAxes, StreamOverTheRingAndAreEnteredAgain) {
  const Folder folder("fewer_axes");
  for (const std::string& name : kMachines) {
    const MachineProfile profile = shipped(name);
    const MachineModel& model = profile.model;
    const std::string letter = model.tilt.present     ? std::string(1, model.tilt.letter)
                               : model.rotary.present ? std::string(1, model.rotary.letter)
                                                      : "";
    const auto turned = [&](double to) { return letter.empty() ? "" : letter + std::to_string(to); };
    const auto at = [&](double x, double y, double z, double turn) {
      return Joints{x, y, z, model.tilt.present ? turn : 0.0, model.rotary.present ? turn : 0.0};
    };
    const std::string program =
        "G21 G90 G94\nG0 X1 Y2 Z60" + turned(5) + "\nG1 X10 F3000\nG1 Y4" + turned(-20) + "\nG1 Z55\nM2\n";
    const std::string path = folder.write(name + ".nc", program);
    std::vector<Joints> executed;
    RingWire wire(model, {}, {}, SeededBug::kNone, [&](const sim::TraceRow& row) {
      if (row.command.op == sim::Op::kRapid || row.command.op == sim::Op::kFeed)
        executed.push_back(row.command.target);
    });
    const LinkSpec link = *parse_link("modbus-tcp:h:1", profile.wire, &model);
    const auto sent = send_over(path, link, wire, wire, {}, {});
    ASSERT_TRUE(sent) << name << ": " << sent.error().message;
    EXPECT_EQ(executed, (std::vector<Joints>{at(1, 2, 60, 5), at(10, 2, 60, 5), at(10, 4, 60, -20),
                                             at(10, 4, 55, -20)}))
        << name;
    const auto place = read_place(link, model, wire, wire);
    ASSERT_TRUE(place && *place) << name;
    for (const char none : std::string("ABC")) {
      if (letter == std::string(1, none)) continue;
      const auto refused =
          send_over(folder.write("wrong.nc", "G0 X0 Y0 Z0" + turned(0) + " " + none + "5\nM2\n"), link, wire,
                    wire, {}, {});
      ASSERT_FALSE(refused) << name << none;
      EXPECT_NE(refused.error().message.find("no such axis"), std::string::npos) << refused.error().message;
    }
    for (const LinkKind kind : {LinkKind::kGrbl, LinkKind::kModbusTcp}) {
      ReentryOptions options;
      options.from = kind == LinkKind::kGrbl ? 5 : 4;  // lines, or blocks
      options.retract = 10.0;
      options.stands = at(10, 4, 60, -20);
      const auto entry = plan_reentry(path, kind, profile, options);
      ASSERT_TRUE(entry) << name << ": " << entry.error().message;
      EXPECT_NE(entry->preview.find("line 5: G1Z55"), std::string::npos) << entry->preview;
      for (const char none : std::string("ABC"))
        EXPECT_TRUE(letter == std::string(1, none) ||
                    entry->head.find(std::string(" ") + none) == std::string::npos)
            << entry->head;
      std::ofstream out(folder.path + "/enter.nc");
      ASSERT_TRUE(write_reentry(path, *entry, out));
      out.close();
      if (kind == LinkKind::kGrbl) continue;
      const auto entered = send_over(folder.path + "/enter.nc", link, wire, wire, {}, {});
      EXPECT_TRUE(entered) << name << ": " << entered.error().message;
    }
  }
}

TEST(FewerAxes, ProfilesSayWhatTheyLack) {
  EXPECT_NE(describe(shipped("mill-3x")).find("rotary: none"), std::string::npos)
      << describe(shipped("mill-3x"));
  const std::string head = "name: x\nlinear:\n";
  std::string linear;
  for (const char* axis : {"x", "y", "z"})
    linear += std::string("  ") + axis +
              ": {min_mm: -1, max_mm: 1, velocity_mm_per_min: 1, acceleration_mm_per_s2: 1}\n";
  const auto trunnion = parse_machine(head + linear + "structure: table-table\n", "m.yaml");
  ASSERT_FALSE(trunnion);
  EXPECT_NE(trunnion.error().message.find("missing key 'tilt'"), std::string::npos);
  const auto tcp = parse_machine(head + linear + "program: {dialect: fanuc, tcp: true}\n", "m.yaml");
  ASSERT_FALSE(tcp);
  EXPECT_NE(tcp.error().message.find("no rotary axis"), std::string::npos) << tcp.error().message;
  const auto pivot = parse_machine(head + linear + "pivot_to_gauge_mm: [0, 0, -5]\n", "m.yaml");
  ASSERT_FALSE(pivot);
  EXPECT_NE(pivot.error().message.find("without a tilting head"), std::string::npos) << pivot.error().message;
}

}  // namespace
}  // namespace tiltfeed
