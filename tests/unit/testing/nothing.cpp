// A library that is not a component.
extern "C" void walk();
extern "C" void walk() {}
