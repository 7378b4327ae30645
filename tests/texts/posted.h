#pragma once
// CL text of another CAM system posted for a machine that comes along, and the way back from its program.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "daemon/post/post.h"
#include "daemon/post/unpost.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;

inline AptProgram foreign() {
  std::ifstream in(SOURCE_DIR "/tests/golden/foreign.cls");
  const auto program = read_apt(in, "foreign.cls", {});
  EXPECT_TRUE(program) << program.error().message;
  return *program;
}

inline MachineProfile machine(Dialect dialect, bool tcp, const std::string& name = "generic-ac") {
  auto profile = load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml", dialect);
  EXPECT_TRUE(profile) << profile.error().message;
  profile->format.tcp = tcp;
  return *profile;
}

inline PostOptions setup() {
  PostOptions options;
  options.setup.part_zero = {30, -10, 50};
  options.setup.fixture = fixture_of({0, 0, 90});
  return options;
}

inline Result<std::string> program_text(const AptProgram& program, const MachineProfile& profile,
                                        const PostOptions& options) {
  const auto posted = post(program, "in.cls", profile, options);
  if (!posted) return tl::unexpected(posted.error());
  std::ostringstream out;
  if (auto written = write_program(posted->posting, out); !written) return tl::unexpected(written.error());
  return out.str();
}

inline Result<AptProgram> back(const std::string& text, const MachineProfile& profile,
                               const UnpostOptions& options = {}) {
  std::istringstream in(text);
  const auto read = read_nc_program(in, "part.nc", language_of(profile));
  if (!read) return tl::unexpected(read.error());
  return unpost(*read, profile, options);
}

}  // namespace tiltfeed
