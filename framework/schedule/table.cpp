#include <takt/schedule/table.hpp>
