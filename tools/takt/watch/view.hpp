// The view of `takt watch`: which page and row the user has selected, and what each key does.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace takt::tool::watch {

enum class Place { list, details, connections, help };

/// The column by which the list is sorted, in the order on the screen.
enum class Column { name, state, p50, p99, budget, overruns, errors, cycles, missed };
inline constexpr std::size_t kColumns = 9;

enum class Verb { initialize, start, stop, recover, reset, destruct };
const char* to_text(Verb verb);

struct Command {
  Verb verb = Verb::start;
  std::string target;  ///< "DEVICE" or "DEVICE.MODULE"
  bool operator==(const Command&) const = default;
};

struct View {
  Place place = Place::list;
  Column column = Column::name;
  bool reversed = false;
  std::string filter{};       ///< words; a row must have all of them
  bool typing = false;        ///< keys go to the filter
  bool pressed = false;       ///< a key was pressed; until then the first row is selected
  std::string chosen{};       ///< the target of the selected row; stays selected when rows move
  std::size_t chosen_at = 0;  ///< the index of the selected row, for when the row disappears
  bool slipped = false;       ///< the selected row disappeared and another took its place: confirm commands
  std::size_t first = 0;      ///< the first row that is shown
  std::size_t scroll = 0;     ///< lines above the first line that is shown, on all pages but the list
  std::optional<Command> asked{};  ///< waits for confirmation
  std::string message{};           ///< the answer to the last key
};

/// The parts of the screen that the keys need.
struct Shown {
  std::vector<std::string> targets;  ///< all rows of the list, including those that are scrolled out
  std::size_t room = 1;              ///< rows that fit on the screen
  std::size_t length = 0;            ///< total lines of a page other than the list
};

struct Done {
  bool quit = false;
  std::optional<Command> command{};
};

/// Adapts the view to the rows that exist now: keeps the selected row, or selects the row that took its
/// place.
void settle(View& view, const Shown& shown);

/// Handles a key of os::Keyboard.
Done press(View& view, int key, const Shown& shown);

}  // namespace takt::tool::watch
