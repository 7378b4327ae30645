// From a table of readings to a profile: what is read, what is refused, what the file says afterwards.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "daemon/measure/measure_report.h"
#include "daemon/measure/rest_picture.h"
#include "kinematics/basics/decimal.h"
#include "tests/daemon/hidden_machine.h"

namespace tiltfeed::daemon {
namespace {

std::string profile_text(const std::string& name) {
  std::ifstream in(SOURCE_DIR "/config/machines/" + name + ".yaml");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

config::MachineProfile profile_of(const std::string& text) {
  const auto profile = config::parse_machine(text, "my.yaml");
  EXPECT_TRUE(profile) << profile.error().message;
  return profile.value_or(config::MachineProfile{});
}

std::string table_of(const BallReadings& readings, int decimals) {
  std::string text = "# probed on Monday\nrotary_deg; tilt_deg;x_mm;y_mm;z_mm;place;tool_length_mm\r\n";
  for (const BallReading& one : readings.all)
    text += decimal(one.at.rotary, 3) + ";" + decimal(one.at.tilt, 3) + ";" + decimal(one.axes.x, decimals) +
            ";" + decimal(one.axes.y, decimals) + "; " + decimal(one.axes.z, decimals) + ";" +
            readings.places[static_cast<std::size_t>(one.place)] + ";" + decimal(one.at.tool_length, 3) +
            "\r\n";
  return text;
}

std::vector<BallPlace> places(std::vector<double> tilts, std::vector<double> turns) {
  std::vector<BallPlace> all;
  for (const double a : tilts)
    for (const double c : turns) all.push_back({a, c, 120.0});
  return all;
}

TEST(BallReadings, SaysWhatIsWrongWithATable) {
  const MachineModel machine = profile_of(profile_text("generic-ac")).model;
  const std::string head = "tilt_deg,rotary_deg,x_mm,y_mm,z_mm,place\n";
  for (const auto& [text, expected] : {
           std::pair<std::string, std::string>{"", "has no readings"},
           {"tilt_deg,x_mm,y_mm,z_mm\n", "t.csv:1: column rotary_deg is missing"},
           {"tilt_deg,rotary_deg,x,y_mm,z_mm\n", "t.csv:1: unknown column 'x'"},
           {"tilt_deg,tilt_deg,rotary_deg,x_mm,y_mm,z_mm\n", "t.csv:1: column tilt_deg is there twice"},
           {head + "0,0,1,2\n", "t.csv:2: 4 values; expected 6"},
           {head + "0,0,1,2,nan,1\n", "t.csv:2: z_mm: 'nan' is no number"},
           {head + "0,0,1,2,1e9,1\n", "t.csv:2: z_mm: '1e9' is no number"},
           {head + "0,0,1,2,3x,1\n", "t.csv:2: z_mm: '3x' is no number"},
           {head + "0,0,1,2,,1\n", "t.csv:2: z_mm: '' is no number"},
           {head + "0,0,1,2,3,\n", "t.csv:2: place is empty"},
           {head + "0,0,1,2,3,a\n0,5,1,2,3,a\n", "t.csv:3: place a has other words"},
           {head + "0,0,1,2,3,a\n0,0,1,2,4,a\n", "place a has 2 touches; expected at least 4"},
       }) {
    const auto read = read_ball_readings(text, "t.csv", machine, 100.0);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().code, Code::kInput);
    EXPECT_NE(read.error().message.find(expected), std::string::npos) << read.error().message;
  }
  EXPECT_FALSE(read_ball_readings(head + "0,0,1,2,3,1\n", "t.csv", machine, -1.0));
}

// Each profile is written, loads, keeps every other line, and its machine is the hidden one.
TEST(MeasuredProfile, IsTheHiddenMachineWithTheOldValuesAsRemarks) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc", "dmu-nutating-bc",
                           "vmc-bhead-bc", "mill-4x-table-a"}) {
    SCOPED_TRACE(name);
    std::mt19937 random(4);
    const std::string text = profile_text(name);
    const config::MachineProfile before = profile_of(text);
    const MachineModel real = hidden(before.model, random, 0.3, 0.1);
    std::vector<BallPlace> at = places({-60, -20, 20, 60}, {-80, 0, 45, 80});
    if (!before.model.tilt.present)
      for (BallPlace& one : at) one.tilt = 0.0;
    const BallReadings readings = measured(real, {120, 60, 80}, at, 0.0, true, random);
    std::string table = table_of(readings, 6);
    const auto read = read_ball_readings(table, "t.csv", before.model, -1.0);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->all.size(), readings.all.size());
    const auto m = measure(text, before, *read, 0.006, 10);
    ASSERT_TRUE(m) << m.error().message;
    EXPECT_TRUE(m->good()) << doubts(*m);
    const auto written = measured_profile(text, before, m->machine, m->changes, remarks(*m, "2026-11-23"));
    ASSERT_TRUE(written) << written.error().message;
    const config::MachineProfile now = profile_of(written->text);
    EXPECT_EQ(written->check_dropped, !before.vectors.empty());
    EXPECT_LT(worst_tip(real, now.model, 120.0, 300, random), 5e-4);
    EXPECT_NE(written->text.find("# Measured 2026-11-23 by"), std::string::npos);
    for (const ProfileChange& one : m->changes) {
      EXPECT_NE(written->text.find("#   " + one.key + ": spread "), std::string::npos) << one.key;
      EXPECT_NE(written->text.find("was " + (one.before.empty() ? "not stated" : one.before)),
                std::string::npos);
    }
    // Measured again, nothing changes but the last digits.
    const auto again = measure(written->text, now, *read, 0.006, 10);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_LT(again->tip_before, 5e-4);
  }
}

TEST(Measured, SaysWhichPlacesWouldHelp) {
  std::mt19937 random(6);
  const std::string text = profile_text("generic-ac");
  const config::MachineProfile before = profile_of(text);
  const MachineModel real = hidden(before.model, random, 0.3, 0.1);
  const auto standing =
      measure(text, before,
              measured(real, {120, 60, 80}, places({0}, {0, 60, 120, 180, 240, 300}), 0.002, false, random),
              0.006, 40);
  ASSERT_TRUE(standing) << standing.error().message;
  EXPECT_FALSE(standing->good());
  EXPECT_NE(doubts(*standing).find("A stands at 0 in all places, C stands at 6 words from 0 to 300"),
            std::string::npos)
      << doubts(*standing);
  EXPECT_NE(doubts(*standing).find("measure at these places, too: A"), std::string::npos);
  EXPECT_EQ(report_text(*standing).find("tip within"), std::string::npos);
  const auto weak = measure(
      text, before,
      measured(real, {120, 60, 80}, places({0, 20, 40}, {0, 90, 180, 270}), 0.002, false, random), 0.006, 40);
  ASSERT_TRUE(weak) << weak.error().message;
  EXPECT_TRUE(weak->fit.untold.empty());
  EXPECT_NE(doubts(*weak).find("above 30"), std::string::npos) << doubts(*weak);
  EXPECT_NE(remarks(*weak, "2026-11-23")[2].find("# KNOWN BADLY: the condition is "), std::string::npos);
  const std::string picture = rest_picture(weak->fit, before.model, weak->readings.places, weak->next);
  std::size_t circles = 0;
  for (std::size_t at = 0; (at = picture.find("<circle", at)) != std::string::npos; ++at) ++circles;
  EXPECT_EQ(circles, 12u);
  EXPECT_TRUE(picture.ends_with("</svg>\n"));
}

// A table without readings holds places enough.
TEST(Measured, BeginsWithPlacesThatSuffice) {
  std::mt19937 random(8);
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "dmu-nutating-bc"}) {
    SCOPED_TRACE(name);
    const MachineModel before = profile_of(profile_text(name)).model;
    const auto next = next_places(nothing_measured(before, 120.0, false), before, 0.002, 0.003, 40);
    ASSERT_LE(next.size(), 40u);
    // The trunnion tilts by 50 degrees to one side only, which tells less.
    ASSERT_LE(next.back().tip, before.tilt.max < 60.0 ? 0.005 : 0.003);
    std::vector<BallPlace> at;
    for (const NextPlace& one : next) at.push_back(one.at);
    const MachineModel real = hidden(before, random, 0.3, 0.1);
    const auto fit = fit_pivots(before, measured(real, {120, 60, 80}, at, 0.002, false, random));
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_TRUE(fit->untold.empty());
    const MachineModel found = settled(fit->found, before, fit->spindle, fit->tool_length);
    EXPECT_LT(worst_tip(real, found, 120.0, 1000, random), 4.0 * next.back().tip);
  }
}

}  // namespace
}  // namespace tiltfeed::daemon
