// As counter, in C++, with the count in an inline variable that was compiled to be one for the whole program
// (STB_GNU_UNIQUE): the one thing of which two copies of an object cannot each have their own.
#include "count_file.hpp"

#include <takt/component.hpp>

inline int shared_count = 0;

class Unique : public takt::Component {
  takt::Property<std::string> file{*this, "file", "", {.text = "Where the count goes at the end."}};

  void run(const takt::Cycle&) noexcept override { ++shared_count; }
  void destruct() override { write_count(file, shared_count); }
};
TAKT_COMPONENT(Unique)
