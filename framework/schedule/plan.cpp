#include <takt/schedule/plan.hpp>
