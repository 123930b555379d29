// The bundled worker as text (build.mjs).
declare module "worker-source" {
  const text: string;
  export default text;
}

// A table of the C++ program as text.
declare module "*.inc" {
  const text: string;
  export default text;
}
