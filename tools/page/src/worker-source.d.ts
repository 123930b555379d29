// The bundled worker as text (build.mjs).
declare module "worker-source" {
  const text: string;
  export default text;
}
