// Style sheets beside airlight.css.
export const styles = ["airlight.css", "picture.css", "panels/transfer.css", "panels/joint.css", "panels/probe.css", "panels/slices.css", "opening.css"];
