#pragma once
// What can be wrong with a line of a program.

namespace tiltfeed::sim {

/// What is wrong with a line; the value is the error number that a Grbl controller answers.
enum class Fault : int {
  kNone = 0,
  kNoLetter = 1,        ///< a word does not start with a letter
  kBadNumber = 2,       ///< a word's number is missing or malformed
  kNegative = 4,        ///< F, S, T or P below zero
  kUnsupported = 20,    ///< a code or letter that this machine does not have
  kModalConflict = 21,  ///< two codes of one modal group
  kNoFeed = 22,         ///< feed move without F
  kNotInteger = 23,     ///< a code or number that must be whole
  kRepeatedWord = 25,   ///< the same letter twice
  kNoMotionMode = 26,   ///< axis words, and neither G0 nor G1 in force
  kLineNumber = 27,     ///< N out of range
  kMissingP = 28,       ///< G4 without P
  kBadArc = 33,         ///< an arc whose end is not on the circle round its centre
  kNoCentre = 35,       ///< an arc without I J K of its plane
  kUnusedWord = 36,     ///< a word that no code of the line uses
};

}  // namespace tiltfeed::sim
