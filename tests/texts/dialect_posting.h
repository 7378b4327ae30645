#pragma once
// Every dialect, with TCP where the control has it: a machine of it, the program of given words, and the
// language to read it back in.

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "daemon/post/block.h"
#include "daemon/post/dialect.h"
#include "daemon/post/nc_reader.h"
#include "daemon/post/nc_rules.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;

struct DialectCase {
  Dialect dialect;
  bool tcp;
};

inline std::vector<DialectCase> dialect_cases() {
  std::vector<DialectCase> all;
  for (const DialectName& one : kDialects) {
    all.push_back({one.dialect, false});
    if (has_tcp(one.dialect)) all.push_back({one.dialect, true});
  }
  return all;
}

inline std::string case_name(const testing::TestParamInfo<DialectCase>& one) {
  return std::string(name_of(one.param.dialect).name) + (one.param.tcp ? "_tcp" : "");
}

inline MachineProfile profile_of(const DialectCase& c) {
  MachineProfile profile;
  MachineModel& m = profile.model;
  m.name = "test-bc";
  m.x = m.y = m.z = {-1000, 1000, 12000, 2000};
  m.tilt = {'B', {0, 1, 0}, +1, 0.0, -120, 120, 5400, 1000};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -2e6, 2e6, 7200, 1000};
  m.pivot_to_gauge = {0, 0, -150};
  profile.format = usual_format(c.dialect);
  profile.format.tcp = c.tcp;
  return profile;
}

inline Posting posting_of(const DialectCase& c, const std::vector<const JointPath*>& paths) {
  Posting posting{"part 7", profile_of(c), {}, {}};
  int tool = 3;
  for (const JointPath* path : paths) {
    Operation op;
    op.words = path;
    op.setup.part_zero = {20, -10, 60.5};
    op.setup.tool_length = op.tool.length = 100.25 - tool;
    op.tool.diameter = 6;
    op.tool_number = tool++;
    op.cut_feed = Feed::from_mm_per_min(1500);
    op.plunge_feed = Feed::from_mm_per_min(400);
    op.events = {{0, EventKind::kSpindle, tool % 2 ? 8000.0 : -9000.0, ""},
                 {0, EventKind::kCoolant, 1.0, ""}};
    posting.operations.push_back(op);
  }
  return posting;
}

inline std::string text_of(const Posting& posting) {
  std::ostringstream out;
  const auto written = write_program(posting, out);
  EXPECT_TRUE(written) << written.error().message;
  EXPECT_EQ(written.value_or(ProgramReport{}).bytes, out.str().size());
  return out.str();
}

/// The blocks before an operation's own `count`: where TCP begins with the table at home it turns in them.
inline std::size_t blocks_before(const DialectCase& c, const TextOperation& op, std::size_t count) {
  const bool turns = c.tcp && begins_at_home(c.dialect) && op.blocks.size() > count;
  return turns ? op.blocks.size() - count : 0;
}

inline TextLanguage language_of(const MachineProfile& profile) { return text_language(profile); }

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace tiltfeed
