#pragma once
// FUZZ_TARGET(name) { ... } gets `bytes`: libFuzzer's entry where clang builds it, a plain function for the
// replay. A broken property ends the process.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#ifdef TILTFEED_REPLAY
#define FUZZ_ENTRY(name) int fuzz_##name(const std::uint8_t* data, std::size_t size)
#else
#define FUZZ_ENTRY(name) extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
#endif

#define FUZZ_TARGET(name)                                          \
  static void fuzz_body_##name(std::string_view bytes);            \
  FUZZ_ENTRY(name);                                                \
  FUZZ_ENTRY(name) {                                               \
    fuzz_body_##name({reinterpret_cast<const char*>(data), size}); \
    return 0;                                                      \
  }                                                                \
  static void fuzz_body_##name([[maybe_unused]] std::string_view bytes)

inline void fuzz_holds(bool property, const char* text, const char* file, int line) {
  if (property) return;
  std::fprintf(stderr, "%s:%d: does not hold: %s\n", file, line, text);
  std::abort();
}

#define HOLDS(property) fuzz_holds(static_cast<bool>(property), #property, __FILE__, __LINE__)
