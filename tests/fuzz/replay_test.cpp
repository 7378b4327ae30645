// The fuzz targets without a fuzzer: their corpus, and seeded damage to it.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

#include "tests/fuzz/fuzz.h"

namespace {

using Target = int (*)(const std::uint8_t*, std::size_t);

}  // namespace

int fuzz_stl(const std::uint8_t* data, std::size_t size);
int fuzz_threemf(const std::uint8_t* data, std::size_t size);
int fuzz_yaml(const std::uint8_t* data, std::size_t size);
int fuzz_gcode(const std::uint8_t* data, std::size_t size);
int fuzz_cl(const std::uint8_t* data, std::size_t size);
int fuzz_apt(const std::uint8_t* data, std::size_t size);
int fuzz_dialect(const std::uint8_t* data, std::size_t size);
int fuzz_reprap(const std::uint8_t* data, std::size_t size);
int fuzz_drip(const std::uint8_t* data, std::size_t size);
int fuzz_websocket(const std::uint8_t* data, std::size_t size);
int fuzz_grbl(const std::uint8_t* data, std::size_t size);
int fuzz_modbus(const std::uint8_t* data, std::size_t size);
int fuzz_journal(const std::uint8_t* data, std::size_t size);
int fuzz_api(const std::uint8_t* data, std::size_t size);
int fuzz_shop(const std::uint8_t* data, std::size_t size);
#ifdef TILTFEED_WITH_CAD
int fuzz_cad(const std::uint8_t* data, std::size_t size);
#endif
#ifdef TILTFEED_WITH_DESK
int fuzz_desk(const std::uint8_t* data, std::size_t size);
#endif

namespace {

constexpr std::size_t kDamages = 30000;  // of the files together, at least one of each

struct Named {
  const char* name;
  Target target;
};

class Replay : public testing::TestWithParam<Named> {};

void run(Target target, const std::string& bytes) {
  target(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

// (session.h, property 5: tests/fuzz/fuzz_session.h)
TEST_P(Replay, CorpusAndDamageToIt) {
  std::mt19937_64 random(1);
  int files = 0;
  run(GetParam().target, "");
  std::vector<std::filesystem::path> paths;
  for (const char* folder : {"/tests/fuzz/corpus/", "/tests/fuzz/learnt/"})
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(SOURCE_DIR) + folder + GetParam().name))
      paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) {
    std::ifstream in(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    ++files;
    run(GetParam().target, bytes);
    for (std::size_t i = 0; i <= kDamages / paths.size(); ++i) {
      std::string damaged = bytes;
      for (std::uint64_t changes = 1 + random() % 4; changes > 0 && !damaged.empty(); --changes) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 4) {
          case 0:
            damaged[at] = static_cast<char>(random());
            break;
          case 1:
            damaged.erase(at, 1 + random() % 9);
            break;
          case 2:
            damaged.insert(at, damaged.substr(random() % damaged.size(), 1 + random() % 20));
            break;
          default:
            damaged.resize(at);
        }
      }
      run(GetParam().target, damaged);
    }
  }
  EXPECT_GE(files, 3) << "the corpus of " << GetParam().name << " is not there";
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Replay,
                         testing::Values(Named{"stl", fuzz_stl}, Named{"yaml", fuzz_yaml},
                                         Named{"gcode", fuzz_gcode}, Named{"cl", fuzz_cl},
                                         Named{"grbl", fuzz_grbl}, Named{"modbus", fuzz_modbus},
                                         Named{"journal", fuzz_journal}, Named{"api", fuzz_api},
                                         Named{"shop", fuzz_shop}, Named{"apt", fuzz_apt},
                                         Named{"dialect", fuzz_dialect}, Named{"reprap", fuzz_reprap},
                                         Named{"drip", fuzz_drip}, Named{"websocket", fuzz_websocket},
                                         Named{"threemf", fuzz_threemf}),
                         [](const auto& info) { return std::string(info.param.name); });
#ifdef TILTFEED_WITH_CAD
INSTANTIATE_TEST_SUITE_P(Cad, Replay, testing::Values(Named{"cad", fuzz_cad}),
                         [](const auto& info) { return std::string(info.param.name); });
#endif
#ifdef TILTFEED_WITH_DESK
INSTANTIATE_TEST_SUITE_P(Desk, Replay, testing::Values(Named{"desk", fuzz_desk}),
                         [](const auto& info) { return std::string(info.param.name); });
#endif

}  // namespace
