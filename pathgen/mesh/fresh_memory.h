#pragma once
// Large vectors that several threads fill: the system hands out memory page by page as it is first written
// to, and that is half of what filling costs, so it too is done side by side.

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace tiltfeed::pathgen {

/// Leaves what resize() adds unwritten.
template <class T>
struct Unwritten : std::allocator<T> {
  static_assert(std::is_trivially_copyable_v<T>);
  template <class U>
  struct rebind {
    using other = Unwritten<U>;
  };
  template <class U, class... Values>
  void construct(U* at, Values&&... values) {
    if constexpr (sizeof...(Values) > 0) ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
  }
};

/// A vector whose resize() leaves the new elements undefined: for what is written in full right after.
template <class T>
using FreshVector = std::vector<T, Unwritten<T>>;

/// Writes a byte to each page, side by side.
void touch_pages(void* memory, std::size_t bytes);

/// v.reserve(size) of an empty vector, in pages that are touched side by side.
template <class T>
void reserve_side_by_side(std::vector<T>& v, std::size_t size) {
  v.reserve(size);
  touch_pages(v.data(), size * sizeof(T));
}

/// v.resize(size), likewise.
template <class T>
void resize_side_by_side(std::vector<T>& v, std::size_t size) {
  reserve_side_by_side(v, size);
  v.resize(size);
}

}  // namespace tiltfeed::pathgen
