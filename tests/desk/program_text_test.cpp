#include "desk/service/program_text.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

namespace tiltfeed::desk {
namespace {

std::string file_of(const std::string& text) {
  const std::string path = testing::TempDir() + "program_text_" + std::to_string(::getpid()) + ".nc";
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

ProgramText opened(const std::string& text) {
  Result<ProgramText> opened = ProgramText::open(file_of(text));
  EXPECT_TRUE(opened);
  while (opened->read_on()) {
  }
  return std::move(*opened);
}

TEST(ProgramText, gives_the_lines_of_a_long_file_as_they_stand) {
  std::mt19937 random(3);
  std::vector<std::string> lines;
  std::string text;
  for (int i = 0; i < 50000; ++i) {
    lines.push_back("N" + std::to_string(i) + std::string(random() % 100, 'x'));
    text += lines.back() + (random() % 2 ? "\n" : "\r\n");
  }
  const ProgramText program = opened(text);
  for (const std::uint64_t first : {1u, 2u, 255u, 256u, 257u, 258u, 512u, 513u, 40000u, 49995u}) {
    const std::vector<std::string> found = program.lines(first, 12);
    const std::size_t from = first - 1, count = std::min<std::size_t>(12, lines.size() - from);
    ASSERT_EQ(found.size(), count) << first;
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(found[i], lines[from + i]) << first;
  }
  EXPECT_TRUE(program.lines(50001, 12).empty());
  EXPECT_TRUE(program.lines(1000000, 12).empty());
  EXPECT_TRUE(program.lines(0, 12).empty());
}

TEST(ProgramText, takes_odd_files) {
  EXPECT_TRUE(opened("").lines(1, 3).empty());
  EXPECT_EQ(opened("G0").lines(1, 3), std::vector<std::string>{"G0"}) << "without an end of line";
  EXPECT_EQ(opened("\n\nM2\n").lines(1, 9), (std::vector<std::string>{"", "", "M2"}));
  EXPECT_EQ(opened(std::string(5000, 'G')).lines(1, 1)[0].size(), ProgramText::kMaxLine);
  EXPECT_FALSE(ProgramText::open(testing::TempDir())) << "a folder";
  EXPECT_FALSE(ProgramText::open("/dev/null")) << "a device";
  const std::string link = testing::TempDir() + "program_text_link_" + std::to_string(::getpid());
  std::filesystem::remove(link);
  std::filesystem::create_symlink(file_of("G0\n"), link);
  EXPECT_FALSE(ProgramText::open(link)) << "a link";
}

}  // namespace
}  // namespace tiltfeed::desk
