#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>

#include "pathgen/mesh/stl.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using Facets = std::vector<std::array<Point<Part>, 3>>;

void expect_refusal(const Result<Stl>& stl, Code code, const std::string& piece) {
  ASSERT_FALSE(stl) << "accepted; expected: " << piece;
  EXPECT_EQ(stl.error().code, code) << stl.error().message;
  EXPECT_NE(stl.error().message.find(piece), std::string::npos)
      << stl.error().message << "\nlacks: " << piece;
}

TEST(StlFile, SizeLimits) {
  // calloc: pages that nobody reads cost nothing.
  const std::uint64_t size = kMaxStlBytes + 1;
  const std::unique_ptr<char, void (*)(void*)> bytes(static_cast<char*>(std::calloc(size, 1)), std::free);
  expect_refusal(parse_stl({bytes.get(), size}, "f", 1.0), Code::kLimit, "over the limit of 536870912");
  const std::uint32_t count = kMaxFacets + 1;
  std::memcpy(bytes.get() + 80, &count, 4);
  expect_refusal(parse_stl({bytes.get(), 84 + 50ull * count}, "f", 1.0), Code::kLimit,
                 "5000001 facets are over the limit of 5000000");

  const std::string path = testing::TempDir() + "huge.stl";
  std::ofstream(path).put('s');
  std::filesystem::resize_file(path, size);
  expect_refusal(read_stl(path, 1.0), Code::kLimit, "over the limit of 536870912");
  std::filesystem::remove(path);
}

TEST(StlFile, WrittenFileReadsBack) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> mantissa(-1.0F, 1.0F);
  std::uniform_int_distribution<int> exponent(-60, 12);
  Facets facets(300);
  for (auto& f : facets)
    for (Point<Part>& p : f)
      for (double* c : {&p.x, &p.y, &p.z}) *c = std::ldexp(mantissa(random), exponent(random));
  const Folder folder("stl_written");
  const std::string path = folder.path + "/part.stl";
  ASSERT_TRUE(write_stl(path, facets));
  EXPECT_EQ(std::filesystem::file_size(path), 84U + 50U * 300U);
  const Result<Stl> back = read_stl(path, 1.0);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_TRUE(back->binary);
  EXPECT_TRUE(back->warnings.empty());
  EXPECT_EQ(back->facets, facets);

  // The normal in the file is the right-hand one.
  ASSERT_TRUE(write_stl(path, {{{{0, 0, 5}, {2, 0, 5}, {0, 3, 5}}}}));
  std::ifstream file(path, std::ios::binary);
  float normal[3];
  file.seekg(84).read(reinterpret_cast<char*>(normal), 12);
  EXPECT_TRUE(normal[0] == 0.0F && normal[1] == 0.0F && normal[2] == 1.0F);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);  // nothing left beside
}

TEST(StlFile, FailedWritesLeaveNothingBehind) {
  const Folder folder("stl_failed");
  std::filesystem::create_directories(folder.path + "/taken.stl/inside");
  const Facets one = {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}};
  const auto into_folder = write_stl(folder.path + "/taken.stl", one);
  ASSERT_FALSE(into_folder);
  EXPECT_EQ(into_folder.error().code, Code::kIo);
  EXPECT_EQ(write_stl(folder.path + "/missing/part.stl", one).error().code, Code::kIo);
  EXPECT_EQ(write_stl(folder.path + "/part.stl", {}).error().code, Code::kInput);
  EXPECT_EQ(write_stl(folder.path + "/part.stl", {{{{0, 0, 0}, {1e39, 0, 0}, {0, 1, 0}}}}).error().code,
            Code::kInput);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);
}

TEST(StlFile, OnlyRegularFilesAreRead) {
  const std::string folder = testing::TempDir();
  expect_refusal(read_stl(folder + "no_such.stl", 1.0), Code::kIo, "no_such.stl: cannot open: No such file");
  expect_refusal(read_stl(folder, 1.0), Code::kIo, "not a regular file");
  const std::string fifo = folder + "stl_fifo";
  std::filesystem::remove(fifo);
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  expect_refusal(read_stl(fifo, 1.0), Code::kIo, "not a regular file");
  std::filesystem::remove(fifo);
}

}  // namespace
}  // namespace tiltfeed
