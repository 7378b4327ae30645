// The way in of a re-entry held against a job's set-up, by the process that judges programs: what stands in
// its way is named with the line, and what cannot be held is said.

#include "daemon/service/entry_hold.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "daemon/journal/reentry.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/machine/machine.h"
#include "tests/shapes/box_mesh.h"
#include "tests/texts/folder.h"

namespace tiltfeed::daemon {
namespace {

const std::string kProfile = SOURCE_DIR "/config/machines/generic-ac.yaml";

/// A block that rows are cut on top of, with a post beside it or none.
class EntryShop {
 public:
  explicit EntryShop(const std::string& fixtures) : folder_("entry_hold_" + std::to_string(++shops())) {
    std::string stl = "solid box\n";
    const Mesh box = box_mesh({{{{-20, -15, 0}, {20, 15, 20}}}});
    for (const auto& facet : box.facets) {
      stl += "facet normal 0 0 0\nouter loop\n";
      for (const auto corner : facet)
        stl += "vertex " + decimal(box.vertices[corner].x, 6) + " " + decimal(box.vertices[corner].y, 6) +
               " " + decimal(box.vertices[corner].z, 6) + "\n";
      stl += "endloop\nendfacet\n";
    }
    setup_files_.stl = folder_.write("part.stl", stl + "endsolid box\n");
    setup_files_.machine = kProfile;
    setup_files_.job = folder_.write(
        "job.yaml",
        "part: {name: box, stl: part.stl}\n"
        "cutter: {type: ball, diameter_mm: 6, length_mm: 60, shank_length_mm: 30, holder: [{diameter_mm: 20, "
        "length_mm: 30}]}\n"
        "axis: {mode: fixed, n: [0, 0, 1], t: [1, 0, 0]}\npattern: {side_step_mm: 5}\ntolerance_mm: 0.02\n"
        "clearance_mm: 5\napproach_mm: 1\nprogram: {tool: 1}\nfeeds: {cut_mm_per_min: 1500, "
        "plunge_mm_per_min: 500}\n"
        "setup: {part_zero_mm: [0, 0, 100]}\nmachine: " +
            kProfile + "\n" + fixtures);
    profile_ = *config::load_machine(kProfile, config::Dialect::kGrbl);
    setup_.part_zero = {0, 0, 100};
    setup_.tool_length = 60;
    const auto words = [&](Point<Part> tip) {
      const Joints at = place(tip, 0.0);
      return " X" + decimal(at.x, 4) + " Y" + decimal(at.y, 4) + " Z" + decimal(at.z, 4);
    };
    program_ =
        folder_.write("program.nc", "G21 G90 G17 G40 G49 G54 G94\nG0 A0 C0\nG0" + words({0, 0, 40}) + "\nG1" +
                                        words({0, 0, 20}) + " F500\nG1" + words({5, 0, 20}) + "\nG1" +
                                        words({10, 0, 20}) + "\nG0" + words({10, 0, 40}) + "\nM2\n");
  }
  Joints place(Point<Part> tip, double a) const { return solve_linear(profile_.model, setup_, tip, a, 0.0); }
  Result<std::string> held(const std::optional<Joints>& stands, LinkKind kind = LinkKind::kGrbl) const {
    ReentryOptions options;
    options.from = 6;
    options.setup = setup_;
    options.stands = stands;
    const auto entry = plan_reentry(program_, kind, profile_, options);
    if (!entry) return tl::unexpected(entry.error());
    return hold_entry(*entry, setup_files_);
  }

  /// Of a program in a tilted plane.
  Result<std::string> held_in_plane() const {
    const std::string machine = folder_.write("fanuc.yaml", fanuc_profile());
    const auto profile = config::load_machine(machine);
    EXPECT_TRUE(profile) << profile.error().message;
    const std::string text =
        "%\nO0001\n(TILTFEED tool length 60 mm is planned)\n(TILTFEED part zero 0 0 100 mm)\n"
        "G21 G90 G17 G40 G80 G94 G54\nG91 G28 Z0.\nG90\nG49\nG69\nT1 M6\nG0 A30. C0.\nG0 X0. Y-150.\n"
        "G68.2 X0. Y0. Z0. I0. J30. K0.\nG53.1\nG0 G43 H1 X0. Y0. Z40.\nG1 Z30. F300.\nX5.\nX10.\nG0 Z40.\n"
        "G91 G28 Z0.\nG90\nG49\nG69\nM30\n%\n";
    ReentryOptions options;
    options.from = 16;
    const auto entry = plan_reentry(folder_.write("plane.nc", text), LinkKind::kDrip, *profile, options);
    if (!entry) return tl::unexpected(entry.error());
    EntrySetup files = setup_files_;
    files.machine = machine;
    return hold_entry(*entry, files);
  }

  /// From where it stands to the first place of the program, whose lines before it are `head`.
  Result<std::string> start_held(const Joints& stands, const std::string& head = "G0 A0 C0\n") const {
    const std::string text = "G21 G90 G17 G40 G49 G54 G94\nT1\nM0\n" + head + "G0 X0 Y0\nG0 Z" +
                             decimal(place({0, 0, 40}, 0.0).z, 4) + "\nG1 Z" +
                             decimal(place({0, 0, 20}, 0.0).z, 4) + " F500\nM2\n";
    return hold_start(folder_.write("start.nc", text), profile_, stands, setup_files_, LinkKind::kGrbl);
  }

  Result<std::string> back_held(const Joints& stands, const std::string& way) const {
    return hold_way_back(way, profile_, stands, setup_files_, LinkKind::kGrbl);
  }

  EntrySetup setup_files_;

 private:
  /// That of the shop, but for its control.
  static std::string fanuc_profile() {
    std::istringstream in(file_text(kProfile));
    std::string text;
    bool other = false;
    for (std::string line; std::getline(in, line);) {
      if (!line.empty() && line[0] != ' ' && line[0] != '#')
        other = line.starts_with("program:") || line.starts_with("link:");
      if (!other) text += line + "\n";
    }
    return text + "program:\n  dialect: fanuc\n  tilted_planes: true\n";
  }

  static int& shops() {
    static int count = 0;
    return count;
  }
  const Folder folder_;
  config::MachineProfile profile_;
  Setup setup_;
  std::string program_;
};

/// On the way across from where the machine stands to the entry.
const std::string kPost =
    "fixtures:\n  - {name: post, on: part, shape: box, size_mm: [20, 20, 300], at_mm: [150, 0, 0]}\n";

TEST(EntryHold, NamesWhatStandsInTheWay) {
  const EntryShop shop(kPost), clear("");
  const Joints beyond = shop.place({300, 0, 60}, 0.0);
  const auto refused = shop.held(beyond);
  ASSERT_FALSE(refused) << *refused;
  EXPECT_EQ(refused.error().code, Code::kInput);
  const std::string& why = refused.error().message;
  for (const char* words :
       {"fixture \"post\"", "the way in is refused at its line 'G0 X5", "nothing has moved"})
    EXPECT_NE(why.find(words), std::string::npos) << why;
  for (const LinkKind kind : {LinkKind::kGrbl, LinkKind::kRepRap, LinkKind::kModbusTcp}) {
    const auto free = clear.held(beyond, kind);
    ASSERT_TRUE(free) << free.error().message;
    EXPECT_EQ(*free, "held against part, fixtures and machine: the way in keeps clear\n");
  }
}

/// A start goes from where the machine stands by the program's own first moves.
TEST(StartHold, HoldsTheFirstMovesFromWhereItStands) {
  const std::string kept = "held against part, fixtures and machine: the way in keeps clear\n";
  const EntryShop shop(kPost), clear("");
  // Across at the height at which it stands: the post is in the way, and not from the other side.
  const auto refused = shop.start_held(shop.place({300, 0, 60}, 0.0));
  ASSERT_FALSE(refused) << *refused;
  EXPECT_EQ(refused.error().code, Code::kInput);
  for (const char* words : {"the way in is refused at its line 'G0X0Y0'", "fixture \"post\"",
                            "nothing has moved", "tiltfeed machine jog"})
    EXPECT_NE(refused.error().message.find(words), std::string::npos) << refused.error().message;
  for (const auto& held :
       {shop.start_held(shop.place({-300, 0, 60}, 0.0)), clear.start_held(clear.place({300, 0, 60}, 0.0)),
        // Off along Z first, it goes over the post.
        shop.start_held(shop.place({300, 0, 60}, 0.0), "G53 G0 Z0\nG0 A0 C0\n")}) {
    ASSERT_TRUE(held) << held.error().message;
    EXPECT_EQ(*held, kept);
  }
}

TEST(StartHold, HoldsTheRetractAndTheSwing) {
  const std::string off = "G53 G0 Z0\n", turn = "G0 A0 C0\n";
  // Leaned: a shelf over the tip, and a block that it swings into.
  const EntryShop shelf(
      "fixtures:\n  - {name: shelf, on: part, shape: box, size_mm: [40, 40, 10], at_mm: [0, 235, 150]}\n");
  const Joints leaned = shelf.place({0, 250, 60}, -60.0);
  const auto up = shelf.start_held(leaned, off + turn);
  ASSERT_FALSE(up) << *up;
  EXPECT_NE(up.error().message.find("line 'G53G0Z0'"), std::string::npos) << up.error().message;
  EXPECT_NE(up.error().message.find("fixture \"shelf\""), std::string::npos) << up.error().message;
  EXPECT_TRUE(shelf.start_held(shelf.place({100, 250, 60}, -60.0), off + turn));
  const EntryShop block(
      "fixtures:\n  - {name: block, on: part, shape: box, size_mm: [40, 40, 80], at_mm: [0, 432, -100]}\n");
  const auto swing = block.start_held(leaned, turn + off);
  ASSERT_FALSE(swing) << *swing;
  EXPECT_NE(swing.error().message.find("line 'G0A0C0'"), std::string::npos) << swing.error().message;
  EXPECT_NE(swing.error().message.find("fixture \"block\""), std::string::npos) << swing.error().message;
  EXPECT_TRUE(block.start_held(leaned, off + turn)) << "the same swing at the retract";
}

/// The way back from a tool change goes up first, and is held to its end.
TEST(WayBackHold, HoldsAllOfItFromWhereItStands) {
  const std::string way =
      "G21\nG90\nG94\nG53 G0 Z0\nG0 A0 C0\nG0 X0 Y0\nS8000 M3\nM8\nG4 P3.0\nG1 Z{} F500.0\nG93\n";
  const auto back = [&](const EntryShop& shop, Point<Part> to) {
    const std::string height = decimal(shop.place(to, 0.0).z, 4);
    std::string text = way;
    return shop.back_held(shop.place({300, 0, 60}, 0.0), text.replace(text.find("{}"), 2, height));
  };
  const EntryShop post(kPost),
      shelf(
          "fixtures:\n  - {name: shelf, on: part, shape: box, size_mm: [60, 60, 10], "
          "at_mm: [0, 0, 60]}\n");
  const auto over = back(post, {0, 0, 30});
  ASSERT_TRUE(over) << over.error().message;
  EXPECT_EQ(*over, "held against part, fixtures and machine: the way in keeps clear\n");
  // Down at its end, through the shelf over the part.
  const auto down = back(shelf, {0, 0, 30});
  ASSERT_FALSE(down) << *down;
  EXPECT_NE(down.error().message.find("at its line 'G1 Z"), std::string::npos) << down.error().message;
  EXPECT_NE(down.error().message.find("fixture \"shelf\""), std::string::npos) << down.error().message;
}

TEST(StartHold, SaysWhatItDoesNotKnow) {
  EntryShop shop(kPost);
  const Joints beside = shop.place({-300, 0, 60}, 0.0);
  // Where the tool would begin in the part it is to be taken off by hand.
  const auto inside = shop.start_held(shop.place({0, 0, 15}, 0.0));
  ASSERT_FALSE(inside) << *inside;
  EXPECT_NE(inside.error().message.find("gouge: "), std::string::npos) << inside.error().message;
  const auto other = shop.start_held(beside, "G55\nG0 A0 C0\n");
  ASSERT_TRUE(other) << other.error().message;
  EXPECT_NE(other->find("not held against part, fixtures and machine: line 4: 'G55'"), std::string::npos)
      << *other;
  shop.setup_files_.stl = "/tmp/none.stl";
  const auto unread = shop.start_held(beside);
  ASSERT_TRUE(unread) << unread.error().message;
  EXPECT_NE(unread->find("not held against part, fixtures and machine: "), std::string::npos) << *unread;
}

/// Leaned, the retract from where it stands goes along the tool: into what stands there.
TEST(EntryHold, HoldsTheRetractAlongTheTool) {
  // The tool at A 60 goes off towards -Y.
  const EntryShop shop(
      "fixtures:\n  - {name: plate, on: part, shape: box, size_mm: [200, 20, 300], at_mm: [0, -370, 0]}\n");
  const auto refused = shop.held(shop.place({0, -40, 60}, 60.0));
  ASSERT_FALSE(refused) << *refused;
  EXPECT_NE(refused.error().message.find("at its line 'G1 "), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("fixture \"plate\""), std::string::npos) << refused.error().message;
  EXPECT_TRUE(shop.held(shop.place({0, 40, 60}, 0.0)));
}

/// A Fanuc's way in is in a tilted plane, from the retract down to over the entry.
TEST(EntryHold, HoldsTheWayInOfAFanuc) {
  const std::string shelf =
      "fixtures:\n  - {name: shelf, on: part, shape: box, size_mm: [120, 120, 10], at_mm: [0, -60, 150]}\n";
  for (const bool stands_there : {false, true}) {
    const EntryShop shop(stands_there ? shelf : "");
    const auto held = shop.held_in_plane();
    ASSERT_EQ(held.has_value(), !stands_there) << (held ? *held : held.error().message);
    if (held) {
      EXPECT_NE(held->find("keeps clear from its first place on"), std::string::npos) << *held;
      continue;
    }
    EXPECT_NE(held.error().message.find("at its line 'G0 G43 H1 "), std::string::npos)
        << held.error().message;
    EXPECT_NE(held.error().message.find("fixture \"shelf\""), std::string::npos) << held.error().message;
  }
}

TEST(EntryHold, SaysWhatItDoesNotKnow) {
  EntryShop shop(kPost);
  // Where it stands is not reported: from over the entry on.
  const auto blind = shop.held(std::nullopt);
  ASSERT_TRUE(blind) << blind.error().message;
  EXPECT_NE(blind->find("where it stands is not reported"), std::string::npos) << *blind;
  // In the part, as after a fault: the retract is not refused for that.
  const auto inside = shop.held(shop.place({0, 0, 15}, 0.0));
  ASSERT_TRUE(inside) << inside.error().message;
  EXPECT_NE(inside->find("the tool is in the part"), std::string::npos) << *inside;
  // A job that cannot be read, and none.
  shop.setup_files_.stl = "/tmp/none.stl";
  const auto unread = shop.held(shop.place({300, 0, 60}, 0.0));
  ASSERT_TRUE(unread) << unread.error().message;
  EXPECT_NE(unread->find("not held against part, fixtures and machine: "), std::string::npos) << *unread;
  shop.setup_files_.job.clear();
  const auto bare = shop.held(shop.place({300, 0, 60}, 0.0));
  ASSERT_TRUE(bare) << bare.error().message;
  EXPECT_NE(bare->find("handed in by itself"), std::string::npos) << *bare;
}

}  // namespace
}  // namespace tiltfeed::daemon
