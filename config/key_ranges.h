#pragma once
// Ranges that keys of several sections have. These, and those in the *_keys.cpp, are beyond anything that
// fits a machine with a tilting head and a table, so a slipped digit is seen.

#include "config/range.h"

namespace tiltfeed::config {

inline constexpr Range kPartPlace{-10'000.0, 10'000.0};       ///< mm
inline constexpr Range kMachinePlace{-100'000.0, 100'000.0};  ///< mm
inline constexpr Range kSmoothing{0.0, 100.0};                ///< mm
inline constexpr Range kCuttingFeed = above(0.0, 100'000.0);  ///< mm/min
inline constexpr Range kMaxTurn = above(0.0, 180.0);          ///< of the tool axis on a pass, degrees/mm
inline constexpr int kMostFlutes = 100;
inline constexpr int kHighestToolNumber = 9999;
inline constexpr int kHighestAddress = 0xFFFF;  ///< of a Modbus register

}  // namespace tiltfeed::config
