// What of a domain somebody looks at, and what each key changes about that.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace takt::tool::watch {

enum class Place { list, details, connections, help };

/// By what the list is sorted; as they stand beside each other.
enum class Column { name, state, p50, p99, budget, overruns, errors, cycles, missed };
inline constexpr std::size_t kColumns = 9;

enum class Verb { initialize, start, stop, recover, reset, destruct };
const char* to_text(Verb verb);

struct Order {
  Verb verb = Verb::start;
  std::string target;  ///< "DEVICE" or "DEVICE.MODULE"
  bool operator==(const Order&) const = default;
};

struct View {
  Place place = Place::list;
  Column column = Column::name;
  bool reversed = false;
  std::string filter{};          ///< words of which all must be found
  bool typing = false;           ///< keys are the filter's
  bool pressed = false;          ///< a key was; until then the first row is chosen, whichever that is
  std::string chosen{};          ///< the row: follows it when the order changes
  std::size_t chosen_at = 0;     ///< where it was, for when it is gone
  bool slipped = false;          ///< that row was gone and another has its place: orders to it are confirmed
  std::size_t first = 0;         ///< the first row that is shown
  std::size_t scroll = 0;        ///< lines above the first that is shown, everywhere but in the list
  std::optional<Order> asked{};  ///< to be confirmed
  std::string message{};         ///< the answer to the last key
};

/// What is on the screen, as far as keys need to know.
struct Shown {
  std::vector<std::string> targets;  ///< the rows of the list, all of them
  std::size_t room = 1;              ///< rows that are seen at once
  std::size_t length = 0;            ///< lines of what is not the list
};

struct Done {
  bool quit = false;
  std::optional<Order> order{};
};

/// The row that was chosen, or the one that has its place; no other row than is shown.
void settle(View& view, const Shown& shown);

/// A key of os::Keyboard.
Done press(View& view, int key, const Shown& shown);

}  // namespace takt::tool::watch
